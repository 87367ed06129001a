"""Break the core in every place, and see that a dialogue notices: python -m tests.firmware.part.mutants

Every number, operator, condition, statement and word of a table is changed once, one at a time.  What neither dialogues
nor the cases of boundaries nor sanitizers notice is printed, and must be in `equivalent.toml`, with the reason why.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import cases, dialogues, library, witness

EQUIVALENT = Path(__file__).with_name("equivalent.toml")
FILES = (*sorted(path.name for path in library.CORE.glob("*.c")), "sheet.h")
TOKENS = re.compile(
    r"""(?P<string>"[^"]*"|'[^']*')|(?P<number>\b(?:0x[0-9a-f]+|[0-9]+)(?:\.[0-9]+|e[0-9]+)?U?L?L?\b)|(?P<word>\b[A-Za-z_]\w*\b)"""
    r"""|(?P<operator>->|\+\+|--|<<=?|>>=?|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|[-+*/%<>=!&|^~?:,;(){}\[\].])""",
    re.VERBOSE,
)
LONGEST = 2  # talks that take as long as all others together
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
OTHER = {
    "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
    "&&": ("||",), "||": ("&&",), "+": ("-",), "-": ("+",), "*": ("+",), "/": ("*",), "|=": ("=", "&="), "&=":
    ("|=",), "+=": ("-=",), "++": ("--",), "--": ("++",), "<<": (">>",), ">>": ("<<",), "%": ("/",), "!": ("",),
    "&": ("|",), "|": ("&",), "^": ("|",),
}  # fmt: skip
WORDS = {
    "true": "false", "false": "true", "GSC_EOT": "GSC_HOME", "GSC_HOME": "GSC_EOT", "GSC_C200": "GSC_C200S",
    "GSC_C200S": "GSC_C200", "IDLE": "RUNNING", "ENTERING": "IDLE", "RUNNING": "IDLE", "UNSIGNED": "SIGNED",
    "SIGNED": "UNSIGNED", "WITH_SIGN": "SIGNED", "SIGN_ALONE": "SIGN_IF_ANY", "SIGN_IF_ANY": "SIGN_ALONE",
    "WITH_SIGN_BUT_0": "WITH_SIGN", "GSC_MOV": "GSC_RAMP", "GSC_RAMP": "GSC_MOV", "GSC_UO1": "GSC_UO2",
    "GSC_UO2": "GSC_UO3", "GSC_UO3": "GSC_UO1", "GSC_UI1": "GSC_HOME", "FOREIGN": "ACTIVATE", "CLOCK_PS":
    "RELEASE_PS", "RELEASE_PS": "DIR_SETUP_PS", "DIR_SETUP_PS": "RELEASE_PS", "GSC_REC": "GSC_CHS", "GSC_CHS":
    "GSC_REC", "GSC_ENABLE": "GSC_UI1", "GSC_RXD": "GSC_REC", "TO_EOT": "TO_HOME", "TO_HOME": "TO_EOT", "GOOD":
    "BAD", "BAD": "GOOD", "GSC_BR0": "GSC_SEL0", "GSC_SEL0": "GSC_BR0", "OPEN": "999999",
}  # fmt: skip


SANITIZED = ("gcc", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
NOT_NOTICED = "not noticed"
EXITS = ("", "dialogues", "cases", "crashes")  # by the status of the process that plays them


class Mutant(NamedTuple):
    """A change of a file: the characters from `at` on become others."""

    file: str
    line: int
    at: int
    old: str
    new: str

    @property
    def name(self) -> str:
        """Where and what."""
        return f"{self.file}:{self.line}: {self.old or 'nothing'} -> {self.new or 'nothing'}"

    @property
    def key(self) -> str:
        """What no other mutant has."""
        return f"{self.file}:{self.at}:{self.old}:{self.new}"


@dataclass
class Talk:
    """A dialogue as the model had it: what came in to a module, what went out."""

    name: str
    module: witness.Module
    given: NDArray[Any]  # to the core
    model: library.Outcome
    baud_at: dict[int, int]
    since: int
    good: Mapping[str, NDArray[Any]] = field(default_factory=dict)  # what the unbroken core writes down

    def replayed(self, core: library.Library) -> dict[str, NDArray[Any]]:
        """Return what a core writes down."""
        return core.replayed(self.module.part, self.given, self.since, self.module.kept, self.module.looks)

    def difference(self, written: Mapping[str, NDArray[Any]]) -> str:
        """Return in what that differs from the model, in words; empty: nothing."""
        outcome = library.outcome_of(written, int(self.given["at"][-1]))
        return witness.difference(self.model, outcome, self.baud_at, self.module.rests)


# ---------------------------------------------------------------------------------------------------------- the mutants
def mutants_of(file: str, text: str) -> Iterator[Mutant]:
    """Yield the mutants of a file."""
    blank = COMMENT.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    blank = re.sub(
        r"^#(?:include|ifndef|endif|define SHEET_H).*$", lambda match: " " * len(match[0]), blank, flags=re.MULTILINE
    )
    line_at = [0, *(match.end() for match in re.finditer("\n", text))]

    def at(place: int, old: str, new: str) -> Mutant:
        return Mutant(file, sum(start <= place for start in line_at), place, old, new)

    for match in TOKENS.finditer(blank):
        token, kind = match[0], match.lastgroup
        if kind == "number":
            yield from (at(match.start(), token, new) for new in numbers(token))
        elif kind == "word" and token in WORDS:
            yield at(match.start(), token, WORDS[token])
        elif kind == "string" and len(token) > 2 and "\\" not in token:
            yield at(match.start(), token, token[0] + ("q" if token[1] != "q" else "r") + token[2:])
        elif kind == "operator" and token in OTHER and not is_declarator(blank, match):
            yield from (at(match.start(), token, new) for new in OTHER[token])
    for match in re.finditer(
        r"^ +(?! |return|case|default|static|const|extern|enum|struct|break|\{|\})[^\n;{}]*[)\w];$", blank, re.MULTILINE
    ):
        if not re.match(r" +(?:u?int\w+_t|bool|double|gsc_time|char|const|uint8_t|int64_t)\b", match[0]):
            statement = match[0].strip()
            yield at(match.start() + len(match[0]) - len(match[0].lstrip()), statement, ";")
    for match in re.finditer(r"\b(?:if|while) \((.+)\)(?: \{)?$", blank, re.MULTILINE):
        yield at(match.start(1), match[1], f"!({match[1]})")


def is_declarator(text: str, match: re.Match[str]) -> bool:
    """Is this * or & part of a declaration, or of a use of a pointer?"""
    after, before = text[match.end() : match.end() + 1], text[match.start() - 1 : match.start()]
    return match[0] in "*&" and after not in (" ", "\n") and before in " (,*["


def numbers(token: str) -> Iterator[str]:
    """Yield other numbers than one, the nearest."""
    digits, suffix = re.fullmatch(r"(.*?)(U?L?L?)", token).groups()  # type: ignore[union-attr]
    if "." in digits or ("e" in digits and not digits.startswith("0x")):
        yield f"1.1 * {digits}"
        return
    value = int(digits, 0)
    yield f"{value + 1}{suffix}"
    if value > 0:
        yield f"{value - 1}{suffix}"


# ---------------------------------------------------------------------------------------------------------- the witness
def talks(count: int) -> list[Talk]:
    """Return some dialogues and all cases, as the model has them."""
    found = []
    played = [(f"seed {seed}", dialogues.Dialogue(seed)) for seed in range(count)]
    for name, dialogue in [*played, *cases.all_cases()]:
        dialogue.play()
        for number, (module_name, module) in enumerate(dialogue.modules.items()):
            since = dialogue.seed * 0x9E3779B97F4A7C15 % 2**64
            given = library.as_array(module.came())
            found.append(Talk(name, module, given, module.went(), dialogue.baud_at[module_name], since + number))
    return sorted(found, key=lambda talk: len(talk.given) + len(talk.model.times))  # most are noticed by short ones


def examine(path: Path, heard: Sequence[Talk]) -> None:
    """Keep what the unbroken core writes down, which the model confirms.

    Raises:
        AssertionError: it does not.
    """
    core = library.Library(path)
    for talk in heard:
        written = {name: array.copy() for name, array in talk.replayed(core).items()}
        wrong = talk.difference(written)
        assert not wrong, f"{talk.name}: {wrong}"
        talk.good = written


def notices(path: Path, heard: Sequence[Talk]) -> str:
    """Return the name of the first dialogue that differs on a built core; empty: none does."""
    core = library.Library(path)
    for talk in heard:
        written = talk.replayed(core)
        same = all(np.array_equal(written[name], array) for name, array in talk.good.items())
        if not same and talk.difference(written):
            return talk.name
    return ""


def noticed(path: Path, heard: Sequence[Talk], most: int) -> str:
    """Return what notices a built core, in a process of its own, that may compute for so many seconds."""
    child = os.fork()
    if not child:
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (most, most))
            os.close(2)
            name = notices(path, heard)
            os._exit(EXITS.index("dialogues" if name.startswith("seed ") else "cases" if name else ""))
        finally:
            os._exit(EXITS.index("crashes"))
    _, status = os.waitpid(child, 0)
    return EXITS[os.WEXITSTATUS(status)] if os.WIFEXITED(status) else "crashes"


class Workshop:
    """Builds mutants, with the quickest compiler that there is."""

    compiler = shutil.which("tcc") or library.COMPILER

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.texts = {name: (library.CORE / name).read_text("ascii") for name in FILES}
        for path in library.CORE.iterdir():
            (folder / path.name).write_text(path.read_text("ascii"))
        self.units = sorted(path.name for path in library.CORE.glob("*.c"))
        self.number = 0
        self.most = self.most_of_long = 0  # seconds of computing, after which a mutant is stuck

    def library(self) -> Path | None:
        """Return the library, under a new name; None: the compiler refuses it."""
        self.number += 1
        made = self.folder / f"part{self.number}.so"
        quick = [] if self.compiler.endswith("tcc") else ["-Wl,-Bsymbolic"]
        replay = str(library.HERE / "replay.c")
        return (
            made
            if self.compiled(self.compiler, "-shared", "-fPIC", *quick, *self.units, replay, "-lm", "-o", str(made))
            else None
        )

    def compiled(self, *command: str) -> bool:
        """Run a compiler; return whether it takes everything."""
        ran = subprocess.run([*command, "-w", "-I."], cwd=self.folder, capture_output=True, check=False)
        return ran.returncode == 0

    @contextmanager
    def broken(self, mutant: Mutant) -> Iterator[None]:
        """Have the mutant among the files, within the block."""
        text = self.texts[mutant.file]
        assert text[mutant.at :].startswith(mutant.old)
        (self.folder / mutant.file).write_text(text[: mutant.at] + mutant.new + text[mutant.at + len(mutant.old) :])
        yield
        (self.folder / mutant.file).write_text(text)

    def noticed_by(self, heard: Sequence[Talk]) -> str:
        """Return what notices the mutant among the files: one of EXITS, or the compiler; empty: nothing."""
        made = self.library()
        if made is None or not made.exists():
            return "compiler"
        short, long = heard[:-LONGEST], heard[-LONGEST:]
        by = noticed(made, short, self.most) or noticed(made, long, self.most_of_long)
        made.unlink()
        return by

    def measure(self, whole: Path, heard: Sequence[Talk]) -> None:
        """See how long the unbroken core takes: what takes much longer is stuck."""
        for name, some, times in (("most", heard[:-LONGEST], 2), ("most_of_long", heard[-LONGEST:], 5)):
            begun = time.process_time()
            assert not notices(whole, some)
            setattr(self, name, 1 + round(times * (time.process_time() - begun)))

    def prepare(self) -> None:
        """Compile the unbroken core for sanitizers: of a mutant, only its own file is compiled again."""
        assert all(self.compiled(*SANITIZED, "-c", unit) for unit in (*self.units, str(library.HERE / "fuzz.c")))

    def is_unclean(self, mutant: Mutant) -> bool:
        """Do random bytes under sanitizers end in an error?"""
        again = self.units if mutant.file.endswith(".h") else [mutant.file]
        others = [f"{unit[:-2]}.o" for unit in (*self.units, "fuzz.c") if unit not in again]
        if not self.compiled(*SANITIZED, *again, *others, "-lm", "-o", "fuzz"):
            return True
        try:
            ran = subprocess.run([self.folder / "fuzz", "1", "600000"], capture_output=True, check=False, timeout=100)
        except subprocess.TimeoutExpired:
            return True
        return ran.returncode != 0


class Equivalents:
    """What has been argued to be equivalent, and why."""

    def __init__(self) -> None:
        self.rows = tomllib.loads(EQUIVALENT.read_text("utf-8"))["mutant"]
        self.unused = list(range(len(self.rows)))

    def has(self, mutant: Mutant, text: str) -> bool:
        """Is it argued?  `like` of a row is what precedes the place in its line, as a regular expression."""
        begin = text.rfind("\n", 0, mutant.at) + 1
        line = text[begin : text.find("\n", mutant.at)].strip()
        for number, row in enumerate(self.rows):
            same = row["line"] == line if "line" in row else re.search(row["like"] + "$", text[begin : mutant.at])
            if row["file"] == mutant.file and same and f"{mutant.old} -> {mutant.new}" in row["changes"]:
                if number in self.unused:
                    self.unused.remove(number)
                return True
        return False


class Record:
    """What has noticed which mutant so far, in a file: a run that was stopped goes on where it was."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.by: dict[str, str] = json.loads(path.read_text("utf-8")) if path and path.exists() else {}

    def note(self, mutant: Mutant, by: str) -> None:
        """Keep what has noticed a mutant."""
        self.by[mutant.key] = by
        if self.path:
            self.path.write_text(json.dumps(self.by, indent=0) + "\n", "utf-8")


def main() -> int:
    """Make the mutants; return 1 if some are not noticed, nor argued to be equivalent."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dialogues", type=int, default=60)
    parser.add_argument("--only", nargs="*", default=[""], help="mutants whose name has one of these texts")
    parser.add_argument("--sample", type=int, help="so many of them, drawn by --seed")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--state", type=Path, help="where results are kept: those that are there are not sought again")
    given = parser.parse_args()
    argued, record = Equivalents(), Record(given.state)
    heard = talks(given.dialogues)
    with tempfile.TemporaryDirectory() as name:
        shop = Workshop(Path(name))
        whole = shop.library()
        assert whole is not None
        examine(whole, heard)
        shop.measure(whole, heard)
        shop.prepare()
        every = [mutant for file, text in shop.texts.items() for mutant in mutants_of(file, text)]
        chosen = [mutant for mutant in every if any(text in mutant.name for text in given.only)]
        if given.sample is not None:
            chosen = random.Random(given.seed).sample(chosen, min(given.sample, len(chosen)))
        print(f"{len(chosen)} of {len(every)} mutants, {len(heard)} modules in dialogues", flush=True)
        for mutant in chosen:
            text = shop.texts[mutant.file]
            if record.by.get(mutant.key, NOT_NOTICED) == NOT_NOTICED:
                with shop.broken(mutant):
                    by = shop.noticed_by(heard) or "equivalent" * argued.has(mutant, text)
                    record.note(mutant, by or "sanitizers" * shop.is_unclean(mutant) or NOT_NOTICED)
            elif record.by[mutant.key] == "equivalent":
                argued.has(mutant, text)
            if record.by[mutant.key] == NOT_NOTICED:
                print(f"{mutant.name}    {text.splitlines()[mutant.line - 1].strip()}", flush=True)
    counts = Counter(record.by[mutant.key] for mutant in chosen)
    print(dict(counts))
    if len(chosen) == len(every):
        print("rows that nothing needs:", [argued.rows[number] for number in argued.unused])
    return int(counts[NOT_NOTICED] > 0)


if __name__ == "__main__":
    sys.exit(main())
