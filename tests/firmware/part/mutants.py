"""Break the core in every place, and see that a dialogue notices: python -m tests.firmware.part.mutants

Every number, operator, condition, statement and word of a table is changed once, one at a time.  What neither dialogues
nor the cases of boundaries nor sanitizers notice is printed, and must be in `equivalent.toml`, with the reason why.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from . import cases, dialogues, library, witness

EQUIVALENT = Path(__file__).with_name("equivalent.toml")
FILES = (*sorted(path.name for path in library.CORE.glob("*.c")), "sheet.h")
TOKENS = re.compile(
    r"""(?P<string>"[^"]*"|'[^']*')|(?P<number>\b(?:0x[0-9a-f]+|[0-9]+)(?:\.[0-9]+|e[0-9]+)?U?L?L?\b)|(?P<word>\b[A-Za-z_]\w*\b)"""
    r"""|(?P<operator>->|\+\+|--|<<=?|>>=?|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|[-+*/%<>=!&|^~?:,;(){}\[\].])""",
    re.VERBOSE,
)
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


@dataclass
class Talk:
    """A dialogue as the model had it: what came in to a module, what went out."""

    name: str
    module: witness.Module
    events: list[library.Event]
    model: library.Outcome
    baud_at: dict[int, int]
    since: int


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
            found.append(
                Talk(name, module, module.came(), module.went(), dialogue.baud_at[module_name], since + number)
            )
    return sorted(found, key=lambda talk: len(talk.events) + len(talk.model.times))  # most are noticed by short ones


def notices(path: Path, heard: Sequence[Talk]) -> str:
    """Return which dialogue differs on a built core; empty: none."""
    core = library.Library(path)
    for talk in heard:
        found = core.play(talk.module.part, talk.events, talk.since, talk.module.kept, talk.module.looks)
        if wrong := witness.difference(talk.model, found, talk.baud_at, talk.module.rests):
            return f"{talk.name}: {wrong}"
    return ""


def noticed(path: Path, heard: Sequence[Talk], most: int) -> bool:
    """Does a dialogue differ, or the core crash, or compute for more than some seconds?  In a process of its own."""
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))
        os.close(2)
        os._exit(1 if notices(path, heard) else 0)
    _, status = os.waitpid(child, 0)
    return status != 0


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
        self.most = 0  # seconds of computing, after which a mutant is stuck

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

    def is_noticed(self, heard: Sequence[Talk]) -> str:
        """Return what notices the mutant among the files: "dialogues", "sanitizers", "compiler"; empty: nothing."""
        made = self.library()
        if made is None:
            return "compiler"
        if not made.exists():
            return "compiler"
        by_dialogues = noticed(made, heard, self.most)
        made.unlink()
        return "dialogues" if by_dialogues else "sanitizers" * self.is_unclean()

    def is_unclean(self) -> bool:
        """Do random bytes under sanitizers end in an error?"""
        flags = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
        if not self.compiled("gcc", *flags, *self.units, str(library.HERE / "fuzz.c"), "-lm", "-o", "fuzz"):
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


def main() -> int:
    """Make the mutants; return 1 if some are not noticed, nor argued to be equivalent."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dialogues", type=int, default=60)
    parser.add_argument("--only", nargs="*", default=[""], help="mutants whose name has one of these texts")
    given = parser.parse_args()
    argued = Equivalents()
    heard = talks(given.dialogues)
    counts = dict.fromkeys(("dialogues", "sanitizers", "compiler", "equivalent", "not noticed"), 0)
    with tempfile.TemporaryDirectory() as name:
        shop = Workshop(Path(name))
        whole = shop.library()
        begun = time.process_time()
        assert whole is not None and not notices(whole, heard), whole and notices(whole, heard)
        shop.most = 2 + int(2 * (time.process_time() - begun))
        every = [mutant for file, text in shop.texts.items() for mutant in mutants_of(file, text)]
        for mutant in [mutant for mutant in every if any(text in mutant.name for text in given.only)]:
            with shop.broken(mutant):
                by = shop.is_noticed(heard)
            text = shop.texts[mutant.file]
            if not by:
                by = "equivalent" if argued.has(mutant, text) else "not noticed"
            counts[by] += 1
            if by == "not noticed":
                print(f"{mutant.name}    {text.splitlines()[mutant.line - 1].strip()}", flush=True)
    print(counts)
    if not any(given.only):
        print("rows that nothing needs:", [argued.rows[number] for number in argued.unused])
    return int(counts["not noticed"] > 0)


if __name__ == "__main__":
    sys.exit(main())
