"""Translates a bench file for another part or controller: each chip's program, and the wiring of the chips.

If the target is one of our parts, the result is again a bench file, with the original comments: its
chips are that part, and its wires, external signals and recordings name that part's pins.  With any
other target there is one controller per chip; it runs the program of that chip by itself, at the same
time as the other controllers.  The wires between the controllers are listed, and must be connected by
hand.  Tables of the bench file without a counterpart are commented out, and listed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

from ..bench import Bench
from ..bench.file import BenchFile
from ..chips import sheet_of
from ..core.datasheet.table import Sheet
from ..core.messages.calls import answering
from ..errors import BenchFileError, UsageError
from .host_directives import ENDING
from .target_writer import WARNING, WriterOptions
from .translate import Translation, known, translate_text
from .writers import TARGETS

if TYPE_CHECKING:
    from ..core.chip import Chip

HEAD = re.compile(r"^\[{1,2}\s*(\w+)", re.MULTILINE)
KEY = re.compile(r"^\s*([\w-]+)\s*=")
RESULT = "bench.toml"
NOT_POSSIBLE = "# NOT POSSIBLE: "
SAME_LEVEL = ("output", "input", "step", "direction")  # roles whose levels are set by the program


@dataclass(frozen=True, slots=True)
class BenchLine:
    """An element of the source's bench that is not a program, such as a wire.

    `what` is its description, `becomes` its counterpart in the result (empty: there is none), and `remedy`
    is advice to the user.
    """

    what: str
    becomes: str = ""
    remedy: str = ""


@dataclass(frozen=True, slots=True)
class BenchTranslation:
    """A translated bench.

    Attributes:
        where: the path of the source's bench file.
        to: the target.
        programs: the translations of the programs, by chip name.
        lines: the wires and other tables, each with its counterpart.
        files: the texts to write, by file name.
    """

    where: str
    to: str
    programs: Mapping[str, Translation]
    lines: tuple[BenchLine, ...]
    files: Mapping[str, str]

    @property
    def bench(self) -> str:
        """The name of the result's bench file in `files`; empty if the target is not one of our parts."""
        return RESULT if RESULT in self.files else ""


@answering("translate_bench()")
def translate_bench(
    path: str | PathLike[str],
    to: str,
    *,
    options: WriterOptions | None = None,
    target_crystal: str | int | None = None,
) -> BenchTranslation:
    """Translate a bench file: return the translation of each of its programs, and of the bench itself.

    Raises:
        UnknownName: the target does not exist.
        UsageError: no chip has a program.
        BenchFileError, ProgramError: the bench, or a program, has errors, or a host is connected to several
            chips.
    """
    name = known(to)
    file = BenchFile(path)
    return _BenchWriter(file, name, options or WriterOptions(), target_crystal).written()


@dataclass(slots=True)
class _OneChip:
    """A chip of the source's bench: its data sheet, its translated program, and the target's pins.

    `pins`: the target's pin for each pin of the chip, by name.
    `interrupted`: something on the bench may end a motion early.
    """

    sheet: Sheet
    crystal: str | int | None
    interrupted: bool = False
    done: Translation | None = None
    pins: dict[str, str] = field(default_factory=dict)


class _BenchWriter:
    """A writer that translates one bench file."""

    def __init__(self, file: BenchFile, to: str, options: WriterOptions, target_crystal: str | int | None) -> None:
        self.file, self.to, self.options, self.target_crystal = file, to, options, target_crystal
        self.mine = None if to in TARGETS else sheet_of(to)
        self.ending = TARGETS[to].ending if self.mine is None else f".{to}"
        bench, _ = file.staged()  # refuses a bench with errors
        driven = {drive.pin for drive in file.tables.drive}
        self.chips = {
            name: _OneChip(chip.sheet, table.crystal, interrupted=may_interrupt(chip, driven))
            for (name, chip), table in zip(bench.chips.items(), file.tables.chip, strict=True)
        }
        self.lines: list[BenchLine] = []
        self.absent: set[str] = set()  # names of parts that are left out

    def written(self) -> BenchTranslation:
        """Return the translated bench."""
        self._programs()
        programs = {name: chip.done for name, chip in self.chips.items() if chip.done is not None}
        bench = {RESULT: self._bench()} if self.mine is not None else {}
        if self.mine is None:
            self._listed()
        files = {f"{name}{self.ending}": self._without_absent(done.text) for name, done in programs.items()} | bench
        return BenchTranslation(str(self.file.path), self.to, programs, tuple(self.lines), files)

    def _without_absent(self, text: str) -> str:
        """Return a program, after turning its directives for parts that the bench leaves out into comments."""
        names = "|".join(map(re.escape, sorted(self.absent)))
        return re.sub(rf"^(?=@\w+ ({names})\b)", "; NOT POSSIBLE: ", text, flags=re.M) if names else text

    def _programs(self) -> None:
        """Translate the program of each host, for the chip to which the host is connected."""
        for number, (host, (text, where)) in enumerate(zip(self.file.tables.host, self.file.programs(), strict=True)):
            names = host.chips or list(self.chips)
            if len(names) != 1:
                raise self.file.error(("host", number), "is connected to several chips; use a separate host for each")
            chip = self.chips.get(names[0])
            if chip is None or not text.strip():
                continue
            if chip.done is not None:
                raise self.file.error(("host", number), f"is the second host of {names[0]}; combine both programs")
            chip.done = translate_text(
                text,
                chip.sheet.part,
                self.to,
                where=where,
                crystal=chip.crystal,
                target_crystal=self.target_crystal,
                options=self.options,
                interrupted=chip.interrupted,
            )
            chip.pins = {theirs: mine for _, theirs, mine in chip.done.report.wiring}
        if all(chip.done is None for chip in self.chips.values()):
            raise UsageError(f"{self.file.path}: no host has commands for a chip: there is nothing to translate")

    # ------------------------------------------------------------------------------------------------------------- pins
    def pin(self, chip: str, name: str) -> str:
        """Return the name of the target's pin for the same purpose as a chip's pin `name`; empty if there is none."""
        one = self.chips[chip]
        if name in one.pins:
            return one.pins[name]
        role = next((pin.role for pin in one.sheet.pins if pin.name == name), "")
        mine = self.mine.role(role) if self.mine is not None and role else None
        return "" if mine is None else mine.name

    def inverted(self, chip: str, name: str) -> bool:
        """Return whether a chip's pin `name` and the target's pin for the same purpose differ in active level."""
        theirs = next((pin for pin in self.chips[chip].sheet.pins if pin.name == name), None)
        mine = self.mine.role(theirs.role) if self.mine is not None and theirs is not None and theirs.role else None
        if theirs is None or mine is None or theirs.role.startswith(SAME_LEVEL):
            return False
        return None not in (theirs.sense, mine.sense) and theirs.sense != mine.sense

    def _places(self, text: str) -> Iterator[tuple[str, str]]:
        """Yield the chip pins that are named in a text, as pairs of chip name and pin name."""
        names = "|".join(map(re.escape, self.chips))
        for found in re.finditer(rf"""(?<=["'])({names})\.(\w+)(?=["'])""", text):
            yield found[1], found[2]

    # -------------------------------------------------------------------------------------------------- our own parts
    def _bench(self) -> str:
        """Return the text of the result's bench file."""
        text = self.file.text
        starts = [found.start() for found in HEAD.finditer(text)]
        head = text[: starts[0]] if starts else text
        blocks = [text[a:b] for a, b in zip(starts, [*starts[1:], len(text)], strict=True)]
        counts: dict[str, int] = {}
        kinds, out = ["", ""], ["".join(f"# {line}\n" for line in WARNING), head]
        for block in blocks:
            found = HEAD.match(block)
            kind = found[1] if found else ""
            number = counts[kind] = counts.get(kind, -1) + 1
            out.append(self._block(kind, number, block))
            kinds.append("" if out[-1].startswith(NOT_POSSIBLE) else kind)
        self._leave_out(kinds, out)
        return "".join(out)

    def _leave_out(self, kinds: list[str], blocks: list[str]) -> None:
        """Comment out the tables in `blocks` that cannot be used with the target, and list them.

        Args:
            kinds: the kind of table of each block; empty for a block that is not a table, or is commented out.
            blocks: the texts of the result, in order.
        """
        while True:
            file = BenchFile(self.file.path, text="".join(blocks))
            try:
                file.put_around(Bench())
            except BenchFileError as error:
                kind, number = error.place[:2] if len(error.place) > 1 else ("", 0)
                if kind not in ("part", "wire", "drive", "record"):
                    raise
                live = [at for at, each in enumerate(kinds) if each == kind]
                at = live[int(number)]
                shown = ", ".join(line for line in blocks[at].splitlines()[1:] if line.strip() and line[0] != "#")
                self.lines.append(BenchLine(f"[[{kind}]] {shown}", "", f"{error.reason}: connect yours"))
                if kind == "part":
                    part = file.tables.part[int(number)]
                    self.absent.add(part.get("name") or part["kind"])
                blocks[at], kinds[at] = f"{NOT_POSSIBLE}{error.reason}\n{commented(blocks[at])}", ""
            else:
                return

    def _block(self, kind: str, number: int, block: str) -> str:
        """Return the translation of a table of the bench file.

        `block` is the text of the table, and `number` its index among the tables of the same kind.
        """
        if kind == "chip":
            return self._chip(block)
        if kind == "host":
            return self._host(number, block)
        places = list(self._places(block))
        if not places:
            return block
        wire_text = f"[[{kind}]] {', '.join(f'{chip}.{pin}' for chip, pin in places)}"
        none = [f"{chip}.{pin}" for chip, pin in places if not self.pin(chip, pin)]
        if none:
            limit = f"the {self.to.upper()} has no pin for {' and '.join(none)}"
            self.lines.append(BenchLine(wire_text, "", f"{limit}: let the host do it, or leave it out"))
            return f"{NOT_POSSIBLE}{limit}\n{commented(block)}"
        for chip, pin in places:
            block = re.sub(rf"""(?<=["']){re.escape(chip)}\.{pin}(?=["'])""", f"{chip}.{self.pin(chip, pin)}", block)
        other = [f"{chip}.{pin}" for chip, pin in places if self.inverted(chip, pin)]
        remedy = f"the active level of {', '.join(other)} differs: invert it" if other else ""
        self.lines.append(
            BenchLine(wire_text, ", ".join(f"{chip}.{self.pin(chip, pin)}" for chip, pin in places), remedy)
        )
        return f"# CHECK: {remedy}\n{block}" if remedy else block

    def _chip(self, block: str) -> str:
        """Return a [[chip]] table for the target, with the chip's name and the straps that the target needs."""
        assert self.mine is not None  # noqa: S101
        lines = []
        for line in block.splitlines(keepends=True):
            key = KEY.match(line)
            if key and key[1] == "part":
                lines.append(re.sub(r"""=\s*["'][^"']*["']""", f'= "{self.to}"', line, count=1))
                straps = self.mine.fastest | self.mine.plain
                if straps:
                    lines.append(f"straps = {{ {', '.join(f'{name} = {level}' for name, level in straps.items())} }}\n")
                if self.target_crystal is not None:
                    lines.append(f'crystal = "{self.target_crystal}"\n')
            elif key and key[1] in ("crystal", "straps", "options"):
                lines.append(f"# was: {line.lstrip()}")
                if key[1] == "options":
                    self.lines.append(BenchLine(line.strip(), "", "options are those of the source: set them by hand"))
            else:
                lines.append(line)
        return "".join(lines)

    def _host(self, number: int, block: str) -> str:
        """Return a [[host]] table that sends the translated program of the chip connected to the host."""
        host = self.file.tables.host[number]
        (name,) = host.chips or list(self.chips)
        if self.chips[name].done is None:
            return block
        kept = [line for line in block.splitlines() if line.lstrip().startswith("#")]
        for key in ("baud", "over"):
            if getattr(host, key) is not None:
                self.lines.append(BenchLine(f"[[host]] {key} of {name}", "", "the target uses its default line"))
        rows = ["[[host]]", f'chips = ["{name}"]', f'file = "{name}{self.ending}"', *kept]
        rows += [f'delay = "{host.delay}"'] if host.delay else []
        after = block[len(block.rstrip()) :]
        return "\n".join(rows) + (after or "\n")

    # --------------------------------------------------------------------------------------------------- other targets
    def _listed(self) -> None:
        """List the wires and parts, which must be connected by hand, and the tables that are left out."""
        for kind, tables in (("wire", self.file.data.get("wire", [])), ("part", self.file.data.get("part", []))):
            for table in tables:
                self._listed_table(kind, table)
        for kind in ("drive", "record", "serve"):
            for table in self.file.data.get(kind, []):
                shown = ", ".join(str(value) for value in table.values())
                self.lines.append(BenchLine(f"[[{kind}]] {shown}", "", "used by the bench only: left out"))

    def _listed_table(self, kind: str, table: Mapping[str, Any]) -> None:
        if kind == "part":
            on = table.get("to", table.get("on", ""))
            self.lines.append(
                BenchLine(f"[[part]] {table.get('kind')}{f' at {on}' if on else ''}", "", "connect yours")
            )
            return
        ends = [str(table.get("from", "")), str(table.get("to", ""))]
        if not any(end.partition(".")[0] in self.chips for end in ends):
            return
        becomes, none = [], []
        for end in ends:
            chip, _, pin = end.partition(".")
            mine = self.pin(chip, pin) if chip in self.chips else pin
            becomes.append(f"{chip}: {mine}")
            if not mine:
                none.append(end)
        if none:
            remedy = f"the {self.to} has no counterpart of {' and '.join(none)}: connect it to a host that decides"
            self.lines.append(BenchLine(f"[[wire]] {' -> '.join(ends)}", "", remedy))
        else:
            invert = "through an inverter" if table.get("invert") else ""
            self.lines.append(BenchLine(f"[[wire]] {' -> '.join(ends)}", " -> ".join(becomes), invert))


def may_interrupt(chip: Chip, driven: set[str]) -> bool:
    """Return whether the bench may end a motion of a chip early: it drives or wires a pin that ends motions.

    Args:
        driven: the pins that the bench file drives, as "chip.pin".
    """
    pins = [chip.pin(pin.name) for pin in chip.sheet.pins if pin.role in ENDING]
    roots = [pin.net.root for pin in pins]
    return any(root.drivers or root.joined for root in roots) or not driven.isdisjoint(
        f"{chip.name}.{pin.name}" for pin in chip.sheet.pins if pin.role in ENDING
    )


def commented(block: str) -> str:
    """Return the text of a table with all its lines commented out, except empty lines."""
    return "".join(f"# {line}" if line.strip() else line for line in block.splitlines(keepends=True))
