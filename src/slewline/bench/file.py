"""Bench files: chips and the parts around them, as TOML.

    [bench]                         # optional, like all its keys
    seed = 0
    until = "2 s"                   # how long a run lasts; by default until everything is idle ...
    timeout = "60 s"                # ... but no longer than this

    [[chip]]
    part = "cy525"                  # or a plug-in: the name of an entry point, or "my_lab.mx10:Mx10", if allowed
    name = "x"                      # by default the part number
    crystal = "11 MHz"
    straps = { ascii_binary = 0 }   # fixed levels of inputs
    bare = false                    # true: without the standard wiring (ABORT high, STEP INHIBIT low ...)
    options = { rate = 80 }         # of the part: register values at power-up, stepwise, cold

    [[part]]                        # anything else with pins; further keys are its own options
    kind = "inverter"               # or a plug-in, as above
    name = "not"                    # a memory may have file = "dump.hex", its image, in this folder or below


    [[wire]]
    from = "x.programmable_output"
    to = "not.in1"
    invert = false

    [[host]]                        # a host computer; script: a run script (slewline run --help), text or list of lines
    chips = ["x"]                   # by default the only chip; several share a bus or a serial line
    delay = "100 us"                # before each byte on a bus; or, on a serial line, baud = 300
    file = "weld.cy525"             # the script from a file in this folder or below; or: script = "A 0"

    [[serve]]                       # for slewline serve: chips on a port; several modules share a line
    chips = ["x"]                   # by default the only chip
    tcp = "127.0.0.1:4001"          # or: rfc2217 = "127.0.0.1:4001", serial = "/dev/ttyUSB0", or pty = "x": a link in
                                    # this folder or below
    framing = false                 # true: lines of text with read-back, for a chip on a bus
    prologix = false                # true: a GPIB controller that accepts Prologix commands, for a chip on a bus

    [[drive]]
    pin = "x.abort"
    level = 0
    at = "12 ms"

    [[record]]                      # pins = []: all of them
    pins = ["x.slew"]
    keep = "10 s"

Times are text with a unit, or whole picoseconds.

A bench file may come from an untrusted source, so all names in it are checked by a `FileGate` (`gate.py`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..chips import CATALOGUE as CHIPS
from ..chips import chip_class, sheet_of
from ..core.messages.near import hint
from ..core.time.timebase import picoseconds
from ..errors import BenchFileError, ProgramError, SlewlineError
from ..gate import FileGate, LinkPlace, read_text
from ..parts import part_class
from .bench import Bench
from .files.images import read_image
from .files.part_order import ordered
from .files.tables import Place, Tables, ValidationError, convert, keys_of
from .files.toml import read_toml
from .hosting import channel_over
from .scripts.program_file import program_script, program_text
from .scripts.script import check_script, run_script
from .scripts.script_runner import Script
from .wiring import free_name, stem_of

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..parts.base.part import Part
    from ..parts.hosts.host import Host

PORTS = ("tcp", "pty", "rfc2217", "serial")
TIMES = 'a time such as "25 us"; text, because a number with a decimal point would be rounded'
ALLOWED = {  # by key, or by type
    **dict.fromkeys(("until", "timeout", "delay", "at", "keep"), TIMES),
    "crystal": 'a frequency such as "11 MHz", or whole hertz',
    "level": "0, 1",
    "tcp": 'HOST:PORT as text, such as "127.0.0.1:4001", or a port of this machine',
    "rfc2217": 'HOST:PORT as text, such as "127.0.0.1:4001", or a port of this machine',
    "straps": "0, 1 for a pin",
    "script": "text, or a list of lines",
    "str": "text",
    "int": "a whole number",
    "bool": "true, false",
    "array": "a list",
    "object": "a table",
}


class PortRequest(NamedTuple):
    """The request for a port: the index of its [[serve]] table, its chips, kind, address and protocol."""

    number: int
    chips: list[Chip]
    kind: str
    where: str | LinkPlace
    framing: bool
    over: str | None
    prologix: bool
    card: str | None


# -------------------------------------------------------------------------------------------------------------- reading
class BenchFile:
    """A bench file in memory: its `tables`, and its text, in which the line numbers for messages are found.

    `text`: the text to use instead of the contents of the file;
    file names in it are still relative to the file's folder.
    """

    def __init__(
        self, path: str | PathLike[str], anywhere: bool = False, allow_code: bool = False, text: str | None = None
    ) -> None:
        self.path, self.gate = Path(path), FileGate(path, anywhere, allow_code)
        if "\n" in str(path):
            raise BenchFileError("load: this is the text of a bench file; give the name of a file")
        if self.path.suffix[1:].lower() in CHIPS.ours:
            raise BenchFileError(
                f"{path}: a program, judging by its extension, not a bench file; run it with `slewline run`, or on a "
                f'bench with a host: [[host]], file = "{self.path.name}"'
            )
        self.text = read_text(path) if text is None else text
        self.data = read_toml(path, self.text)
        try:
            self.tables = convert(self.data, Tables)
        except ValidationError as error:
            raise self.explained(str(error)) from None

    # --------------------------------------------------------------------------------------------------------- errors
    def error(self, place: Place, message: str) -> BenchFileError:
        """Return an error that states the file, and the line and the key of a place in it."""
        line = self.line_of(place)
        at = f"{self.path}, line {line}" if line else str(self.path)
        found = BenchFileError(f"{at}: {_named(place)}{': ' if place else ''}{message}")
        found.place, found.reason = tuple(place), message
        return found

    def line_of(self, place: Place) -> int | None:
        """Return the line of a key, or of its table if the key is not found; None if the table is not found either."""
        if not place:
            return None
        many = len(place) > 1 and isinstance(place[1], int)
        header = re.compile(rf"\s*\[{{{1 + many}}}\s*{re.escape(str(place[0]))}\s*\]{{{1 + many}}}")
        key = next((part for part in place[1:] if isinstance(part, str)), None)
        left, found = (int(place[1]) if many else 0), None
        for number, line in enumerate(self.text.splitlines(), 1):
            if found is None:
                if header.match(line):
                    left, found = left - 1, number if left == 0 else None
            elif re.match(r"\s*\[", line):
                break
            elif key is not None and re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*[.=]", line):
                return number
        return found

    def explained(self, message: str) -> BenchFileError:
        """Return an error with the message of a msgspec error, reworded for the user."""
        reason, _, path = message.partition(" - at `")
        place = [int(index) if index else key for key, index in re.findall(r"\.(\w+)|\[(\d+)\]", path)]
        unknown = re.match(r"Object contains unknown field `(.*)`", reason)
        missing = re.match(r"Object missing required field `(.*)`", reason)
        if unknown:
            keys = keys_of(place)
            remedy = hint(unknown[1], keys) or self.as_option(place, unknown[1])
            return self.error([*place, unknown[1]], f"unknown key; allowed {', '.join(keys)}{remedy}")
        if missing:
            return self.error(place, f"needs the key {missing[1]}; its keys: {', '.join(keys_of(place))}")
        found, key = self.value(place), str(next((part for part in reversed(place) if isinstance(part, str)), ""))
        if len(place) == 1 and key != "bench":
            single = "a single table" if isinstance(found, dict) else repr(found)
            return self.error(place, f"found {single}; write [[{key}]], with two brackets")
        expected = re.findall(r"\w+", (re.match(r"Expected `(.*?)`", reason) or [""])[0])[1:]
        allowed = (
            self.allowed(place, key) or " or ".join(ALLOWED[kind] for kind in expected if kind in ALLOWED) or reason
        )
        return self.error(place, f"found {found!r}; allowed {allowed}")

    def allowed(self, place: Place, key: str) -> str:
        """Return a description of the allowed values of a key (for straps, the pins of the chip); "" if unknown."""
        if "straps" in place:
            pins = self.straps_of(place[:2])
            return f"0, 1 for a pin, such as {{ {pins[0]} = 0 }}; its inputs: {', '.join(pins)}" if pins else ""
        return ALLOWED.get(key, "")

    def as_option(self, place: Place, key: str) -> str:
        """Return a hint for a key of a [[chip]] table that belongs in its `options`; "" for any other key."""
        part = self.value(place).get("part") if len(place) == 2 and place[0] == "chip" else ""
        known = [row.name for row in sheet_of(part).options] if part in CHIPS.ours else []
        found = f"options = {{ {key} = {self.value(place)[key]!r} }}"
        return f"; it is an option of the part: {found}" if key in known else ""

    def straps_of(self, place: Place) -> list[str]:
        """Return the inputs of the chip in a [[chip]] table, those for its baud rate first; [] for a plug-in."""
        part = self.value(place).get("part", "") if len(place) == 2 else ""
        if part not in CHIPS.ours:
            return []
        sheet = sheet_of(part)
        inputs = [row.name for row in sheet.pins if row.in_out in ("in", "both")]
        return list(dict.fromkeys([*sheet.plain, *sheet.fastest, *inputs]))

    def value(self, place: Place) -> Any:
        """Return the value at a place in the file."""
        value: Any = self.data
        for part in place:
            value = value[part]
        return value

    @contextmanager
    def at(self, *place: str | int) -> Iterator[None]:
        """Add the file, line and key to any error in the `with` block; leave a ProgramError unchanged."""
        try:
            yield
        except ProgramError:
            raise
        except (SlewlineError, TypeError, ValueError) as error:
            raise self.error(place, str(error)) from error

    # ------------------------------------------------------------------------------------------------------- the bench
    def load(self, prepare: Callable[[Bench], object] | None = None, **options: Any) -> Bench:
        """Return the bench that the file describes, with its scripts queued.

        Args:
            prepare: called with the bench, before the scripts are queued.
        """
        bench, scripts = self.staged(**options)
        for host, script in scripts:
            check_script(bench, host, script)
        if prepare is not None:
            prepare(bench)
        for host, script in scripts:
            run_script(bench, host, script)
        return bench

    def staged(self, **options: Any) -> tuple[Bench, list[tuple[Host, Script]]]:
        """Return the bench that the file describes, and its hosts, each paired with its script, not yet queued."""
        self.check_times()
        programs = self.programs()
        bench = Bench(seed=self.tables.bench.seed, **options)
        hosts = self.put_around(bench)
        return bench, [(host, program_script(*one, host.chip.sheet)) for host, one in zip(hosts, programs, strict=True)]

    def put_around(self, bench: Bench) -> list[Host]:
        """Put chips, parts, hosts and wires on a bench, start recorders, and drive pins; return the hosts."""
        self.put_parts(bench)
        hosts = self.hosts(bench)
        self.wire(bench)
        return hosts

    def check_times(self) -> None:
        """Check the times `until` and `timeout`, which are not used until the bench runs."""
        for key in ("until", "timeout"):
            time = getattr(self.tables.bench, key)
            with self.at("bench", key):
                picoseconds(0 if time is None else time)

    def programs(self) -> list[tuple[str, str]]:
        """Return the script of each host: its text, and the name of its file or table for messages."""
        found = []
        for number, host in enumerate(self.tables.host):
            if host.file is not None and host.script is not None:
                raise self.error(("host", number, "file"), "given together with script; give one of the two")
            if host.file is not None:
                with self.at("host", number, "file"):
                    path = self.gate.file(host.file)
                    found.append((program_text(path), str(path)))
            else:
                lines = [host.script] if isinstance(host.script, str) else host.script or []
                where = f"{self.path}, {_named(('host', number, 'script'))}"
                found.append(("\n".join(lines), where))
        return found

    def put_parts(self, bench: Bench) -> None:
        """Put chips and parts on the bench."""
        for number, chip in enumerate(self.tables.chip):
            for key in sorted(chip.options.keys() & {*keys_of(["chip"])}):
                raise self.error(("chip", number, "options"), f"{key} is a key of the [[chip]] table, not an option")
            with self.at("chip", number):
                cls = self.gate.code(chip_class, chip.part)
                bench.add(cls, chip.name, chip.crystal, chip.straps, chip.bare, **chip.options)
        made, names = [], [*bench.chips]
        for number, part in enumerate(self.tables.part):
            with self.at("part", number):
                if "kind" not in part:
                    raise SlewlineError("needs the key 'kind', such as kind = \"inverter\"")
                for key in ("kind", "name", "to", "on"):
                    if not isinstance(part.get(key, ""), str):
                        raise SlewlineError(f"{key}: found {part[key]!r}; allowed text")
                made.append(self.gate.code(part_class, part["kind"]))
                names.append(part.get("name") or free_name(stem_of(part["kind"], made[-1]), names))
        names = names[len(bench.chips) :]
        for number in ordered(self.tables.part, names, bench.chips, self._part_error):
            part = self.tables.part[number]
            with self.at("part", number):
                bench.part(part["kind"], **self.part_options(made[number], part) | {"name": names[number]})

    def _part_error(self, number: int, key: str, message: str) -> BenchFileError:
        return self.error(("part", number, key), message)

    def part_options(self, cls: type[Part], part: dict[str, Any]) -> dict[str, Any]:
        """Return the options in a [[part]] table; for a part with a memory image, `file` names the image file."""
        options = {key: value for key, value in part.items() if key != "kind"}
        if "file" in options and any(row.name == "image" for row in cls.options):
            if "image" in options:
                raise SlewlineError("file: given together with image; give one of the two")
            options["image"] = read_image(self.gate.file(options.pop("file")))
        return options

    def hosts(self, bench: Bench) -> list[Host]:
        """Put the hosts on the bench, and return them."""
        found = []
        for number, host in enumerate(self.tables.host):
            chips = self.chips_of(bench, "host", number, host.chips)
            with self.at("host", number):
                one = bench.host(*chips, name=host.name, delay=host.delay, baud=host.baud, over=host.over)
                found.append(one)
        return found

    def chips_of(self, bench: Bench, key: str, number: int, names: list[str]) -> list[Chip]:
        """Return the chips that a table names; if it names none, the only chip of the bench."""
        names = names or (list(bench.chips) if len(bench.chips) == 1 else [])
        if not names:
            raise self.error((key, number), f'no chip named; write chips = ["{next(iter(bench.chips), "x")}"]')
        for name in names:
            if name not in bench.chips:
                known = ", ".join(bench.chips) or "none"
                raise self.error(
                    (key, number, "chips"),
                    f"no chip {name!r} on the bench; available: {known}{hint(name, bench.chips)}",
                )
        return [bench.chips[name] for name in names]

    def served(self, bench: Bench) -> list[PortRequest]:
        """Return the ports requested by [[serve]] tables."""
        found: list[PortRequest] = []
        taken = [
            (name, channel_over(bench.chips[name], host.over))
            for host in self.tables.host
            for name in host.chips or list(bench.chips)
        ]
        for number, table in enumerate(self.tables.serve):
            chips = self.chips_of(bench, "serve", number, table.chips)
            for chip in chips:
                with self.at("serve", number):
                    channel = channel_over(chip, table.over)
                if (chip.name, channel) in taken:
                    raise self.error(("serve", number), f"{chip.name} has a host or a port already; leave one out")
                taken.append((chip.name, channel))
            ports = [(kind, where) for kind in PORTS if (where := getattr(table, kind)) is not None]
            if len(ports) != 1:
                raise self.error(("serve", number), f"found {len(ports)} ports; give one of {', '.join(PORTS)}")
            kind, where = ports[0]
            if table.framing and table.prologix:
                raise self.error(("serve", number), "framing given together with prologix; give one of the two")
            place: str | LinkPlace = str(where)
            with self.at("serve", number, kind):
                if kind == "pty":
                    place = self.gate.link(where)
                elif kind == "serial":
                    place = self.gate.device(where)
            found.append(PortRequest(number, chips, kind, place, table.framing, table.over, table.prologix, table.card))
        return found

    def wire(self, bench: Bench) -> None:
        """Connect the wires, start the recorders, and drive the pins that the file lists."""
        for number, wire in enumerate(self.tables.wire):
            with self.at("wire", number):
                bench.wire(wire.from_, wire.to, wire.invert)
        for number, record in enumerate(self.tables.record):
            with self.at("record", number):
                bench.record(*record.pins, keep=record.keep)
        for number, drive in enumerate(self.tables.drive):
            with self.at("drive", number):
                bench.pin(drive.pin).drive(drive.level, drive.at or None)


def _named(place: Place) -> str:
    """Return a place as printed in messages: ("chip", 0, "crystal") is [[chip]] 1, crystal."""
    if len(place) > 1 and isinstance(place[1], int):
        return ", ".join([f"[[{place[0]}]] {place[1] + 1}", *(str(part) for part in place[2:])])
    return " ".join([f"[{place[0]}]", *(str(part) for part in place[1:])]) if place else ""
