"""Classes that answer questions about events in time, found by their signatures, in groups by their words.

    python -m tests.house.vocabularies [SOURCES]        each vocabulary: its methods by kind, its classes and files

A method is a question if all that it takes are instants and numbers of events, and it returns an instant, a number, a
level or several of them.  Whether a whole number is an instant or a number of an event its type says, or else the name
of the argument.  What is asked, the kind, follows from both sides:

    at         of an instant: how many there are by then, or the level
    next       of an instant: perhaps an instant, or none
    numbered   of a number: the instant of that event
    window     of two instants, or two numbers: the events between them

A class with two kinds, or a protocol with one, has a vocabulary: the names of its questions.  A class that has all
names of a vocabulary, or two of them, uses it, and only what it answers under further names may be another one.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from tests.sources import SOURCES, tree

INSTANT = re.compile(
    r"(.+_)?ps|ps_list|t|(time|instant|tick)s?(_ps)?|now|start|stop|since|until|to|by|earlier|later|begin|end|asked"
)
NUMBER = re.compile(r"k|n|nth|first|last|ind(ex|ices)|(number|count|step|edge|change|event)s?")
TYPED_INSTANTS = {"Ps", "Instant", "Instants", "Tick", "Ticks"}
TYPED_NUMBERS = {"Number", "Numbers", "Count"}
SELECTORS = {"Level", "Probe", "Net", "Terminal", "Pin", "SignalEdges"}  # of which wire, to which level: no question
WHOLE = {"int", "Ps", "Tick", "Count", "Number"}
SEVERAL = {"NDArray", "ndarray", "Array", "Instants", "Ticks", "Numbers", "list", "tuple", "Sequence"}
SEVERAL |= {"Iterable", "Iterator"}
WORD = re.compile(r"[A-Za-z_]\w*")
KINDS = ("at", "next", "numbered", "window")


class Question(NamedTuple):
    """A method that asks for events."""

    name: str
    kind: str


@dataclass
class Answering:
    """A class, with the questions that it answers itself."""

    name: str
    where: str
    bases: list[str]
    protocol: bool
    questions: dict[str, str] = field(default_factory=dict)  # kinds, by the name of the method


class Vocabulary(NamedTuple):
    """Names for questions about events, with those who use them."""

    names: frozenset[str]
    kinds: Mapping[str, str]  # by name
    classes: list[Answering]

    @property
    def title(self) -> str:
        """The first class, which is the protocol if there is one, and the names: "Counter: after at between"."""
        return f"{self.classes[0].name}: {' '.join(sorted(self.names))}"

    def spoken_by(self, asked: Mapping[str, str]) -> bool:
        """Whether questions, with their kinds, are asked in the words of this vocabulary: in all of them, or two."""
        return len(self.kinds.items() & asked.items()) >= min(len(self.names), 2)


def aliases(parsed: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Names of a module that stand for types: `Level = Any`, `Ps: TypeAlias = int`, `Ps = NewType("Ps", int)`."""
    for node in ast.walk(parsed):
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value is not None:
            if ast.unparse(node.annotation).endswith("TypeAlias"):
                yield node.target.id, node.value
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            value = node.value
            if isinstance(value, ast.Call) and ast.unparse(value.func).endswith("NewType") and len(value.args) == 2:
                yield node.targets[0].id, value.args[1]
            elif node.targets[0].id[:1].isupper() and not node.targets[0].id.isupper():
                yield node.targets[0].id, value
        elif type(node).__name__ == "TypeAlias":  # `type Ps = int`, of Python 3.12
            yield node.name.id, node.value  # type: ignore[attr-defined]


def words(annotation: ast.expr | None, known: Mapping[str, ast.expr], most: int = 4) -> set[str]:
    """All names in a type, with those of what its aliases stand for; `most`: how deep."""
    if annotation is None:
        return set()
    found = set()
    for node in ast.walk(annotation):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found |= set(WORD.findall(node.value))
            continue
        name = node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""
        if name:
            found.add(name)
            if name in known and most:
                found |= words(known[name], known, most - 1)
        elif isinstance(node, ast.Constant) and node.value is None:
            found.add("None")
    return found


def role(argument: ast.arg, known: Mapping[str, ast.expr]) -> str:
    """What an argument is: "instant", "number", "selector", or "" for something else."""
    types = words(argument.annotation, known)
    direct = words(argument.annotation, {})
    if "float" in types or not types:
        return ""
    if direct & SELECTORS or argument.arg in ("level", "probe"):
        return "selector"
    if not types & (WHOLE | SEVERAL) or types & {"str", "bytes", "Callable"}:
        return ""
    if direct & TYPED_INSTANTS:
        return "instant"
    if direct & TYPED_NUMBERS:
        return "number"
    return "instant" if INSTANT.fullmatch(argument.arg) else "number" if NUMBER.fullmatch(argument.arg) else ""


def kind(method: ast.FunctionDef | ast.AsyncFunctionDef, known: Mapping[str, ast.expr]) -> str:
    """The kind of question that a method is; "": it is none."""
    given = method.args
    plain = [*given.posonlyargs, *given.args][1:]
    needed = plain[: len(plain) - len(given.defaults)] if given.defaults else plain
    if method.name.startswith("_") or given.vararg or given.kwarg or not needed or method.returns is None:
        return ""
    roles = [role(argument, known) for argument in needed]
    optional = [role(argument, known) for argument in plain[len(needed) :]]
    asked = [each for each in roles if each != "selector"]
    returned, direct = words(method.returns, known), words(method.returns, {})
    if not asked or "" in asked or returned & {"float", "float64", "str", "bytes", "bool_", "Callable"}:
        return ""
    several = bool(returned & SEVERAL)
    if "bool" in returned and not several:
        return ""
    if not (several or returned & WHOLE or direct & {"Level", "Edges", "Any"}):
        return ""
    if several and len(asked) + sum(each in ("instant", "number") for each in optional) >= 2:
        return "window"
    if "number" in asked and "instant" not in asked:
        return "numbered" if len(asked) == 1 else ""
    if not several and ("None" in direct or any(name.startswith(("NotYet", "Never", "When")) for name in direct)):
        return "next"
    return "at"


def answering(sources: Path) -> list[Answering]:
    """All classes under a folder, with the questions that each answers itself."""
    paths = sorted(sources.rglob("*.py"))
    known = {name: value for path in paths for name, value in aliases(tree(path))}
    found = []
    for path in paths:
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.ClassDef):
                bases = [ast.unparse(base).partition("[")[0].rpartition(".")[2] for base in node.bases]
                one = Answering(node.name, path.relative_to(sources).as_posix(), bases, "Protocol" in bases)
                for method in node.body:
                    if isinstance(method, ast.FunctionDef | ast.AsyncFunctionDef):
                        overload = any(ast.unparse(each).endswith("overload") for each in method.decorator_list)
                        which = "" if overload else kind(method, known)
                        if which:
                            one.questions[method.name] = which
                found.append(one)
    return found


def inherited(one: Answering, classes: Mapping[str, list[Answering]], most: int = 9) -> dict[str, str]:
    """The questions of a class and of all above it; of several classes of a name all are taken."""
    found: dict[str, str] = {}
    for base in one.bases if most else []:
        for above in classes.get(base, []):
            if above is not one:
                found |= inherited(above, classes, most - 1)
    return found | one.questions


def vocabularies(sources: Path = SOURCES) -> list[Vocabulary]:
    """All vocabularies under a folder, protocols first, then classes whose bases ask nothing, the largest first."""
    every = answering(sources)
    classes: dict[str, list[Answering]] = {}
    for one in every:
        classes.setdefault(one.name, []).append(one)
    whole = {id(one): inherited(one, classes) for one in every}
    own = {id(one): one.questions.keys() == whole[id(one)].keys() for one in every}  # nothing above it asks
    order = sorted(
        every, key=lambda one: (not one.protocol, not own[id(one)], -len(whole[id(one)]), one.where, one.name)
    )
    found: list[Vocabulary] = []
    for one in order:
        asked = dict(whole[id(one)])
        spoken = [each for each in found if each.spoken_by(asked)]
        for each in spoken:
            each.classes.append(one)
        left = {name: which for name, which in asked.items() if not any(name in each.names for each in spoken)}
        if len(set(left.values())) >= 2 or (left and one.protocol):
            found.append(Vocabulary(frozenset(left), left, [one]))
    return found


def lines(found: Iterable[Vocabulary]) -> Iterator[str]:
    """Describe vocabularies."""
    for number, each in enumerate(found, 1):
        by_kind = {which: sorted(n for n, k in each.kinds.items() if k == which) for which in KINDS}
        yield f"{number:2} {each.classes[0].name}: " + "; ".join(
            f"{which} {', '.join(n)}" for which, n in by_kind.items() if n
        )
        defined = sum(bool(each.names & one.questions.keys()) for one in each.classes)
        files = sorted({one.where for one in each.classes})
        yield f"   {defined} definitions: {', '.join(dict.fromkeys(one.name for one in each.classes))}"
        yield f"   {len(files)} files: {', '.join(files)}"


def main() -> None:
    found = vocabularies(Path(sys.argv[1]) if len(sys.argv) > 1 else SOURCES)
    print(*lines(found), f"{len(found)} vocabularies", sep="\n")


if __name__ == "__main__":
    main()
