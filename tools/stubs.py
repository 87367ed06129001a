"""Write src/slewline/bench/by_name.pyi: the types that `bench.add`, `bench.part` and `bench.host` return for each name.

python tools/stubs.py            write it
python tools/stubs.py --check    fail if it differs from the lists of chips and parts; then check the types of the
                                 examples and of the Python blocks of two pages, as a user would

Parameters are those of the methods; a chip's host is the one that `bench.host` creates for it.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
from inspect import getsource
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import dedent

from slewline.bench import Bench
from slewline.chips import PARTS, chip_class
from slewline.parts import KINDS, part_class

ROOT = Path(__file__).resolve().parent.parent
STUB = ROOT / "src/slewline/bench/by_name.pyi"
PAGES = ("README.md", "docs/howto/host_scripts.md")
UNTOLD = {  # content of a block: declarations that a type checker needs
    "def test_": '# mypy: disable-error-code="no-untyped-def,no-untyped-call"\n',
    "slewline.load(": '# mypy: disable-error-code="union-attr"\n',  # chip or part: the file knows
}
HEAD = """\
# Written by tools/stubs.py from the lists of chips and parts; change those, not this file.

from collections.abc import Mapping
from typing import Any, Literal, Protocol, TypeVar, overload

{imports}

C = TypeVar("C", bound=Chip)
P = TypeVar("P", bound=Part)
"""


def parameters(method: str) -> list[str]:
    """Return the parameters of a method of a bench, as in its source, without the first one."""
    tree = ast.parse(dedent(getsource(getattr(Bench, method)))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    text = ast.unparse(tree.args)
    text = text.partition(", ")[2].removeprefix("/, ")
    return re.split(r", (?=[*\w])(?![^\[]*\])", text)


def protocol(name: str, cases: list[tuple[str, str]], rest: list[str], first: str) -> str:
    """Return a class that is called with one of several first arguments, with the matching return type."""
    return "\n".join([f"\nclass {name}(Protocol):", *(overloaded(case, rest, first) for case in cases)])


def overloaded(case: tuple[str, str], rest: list[str], first: str) -> str:
    """Return one overload of the call."""
    argument, result = case
    given = ", ".join([f"self, /, {first}: {argument}", *rest])
    return f"    @overload\n    def __call__({given}) -> {result}: ..."


def host_of(number: str, over: str | None = None) -> type:
    """Return the class of the host that a bench creates for a chip, over a channel or over its first one."""
    bench = Bench()
    return type(bench.host(bench.add(number), over=over))


def several(chips: dict[str, type]) -> dict[type, list[tuple[str, type]]]:
    """Return the channels of chips with several channels, and the host on each."""
    return {
        cls: [(channel.name, host_of(number, channel.name)) for channel in cls.sheet.channels]
        for number, cls in chips.items()
        if len(cls.sheet.channels) > 1
    }


def hosting_over(others: dict[type, list[tuple[str, type]]], rest: list[str]) -> str:
    """Return the overloads for a host over each channel of chips with several; the first is the default."""
    ways = []
    for cls, found in others.items():
        if any(others.get(base) == found for base in cls.__mro__[1:]):
            continue  # explained in the class above
        for number, (name, host) in enumerate(found):
            asked = [each for each in rest if not each.startswith("over:")]
            asked.append(f'over: Literal["{name}"]' + ("" if number else " | None = None"))
            ways.append("\n" + overloaded((cls.__name__, host.__name__), asked, "*chips"))
    return "".join(ways)


def stub() -> str:
    """Return the text of the stub."""
    chips = {number: chip_class(number) for number in PARTS}
    kinds = {kind: part_class(kind) for kind in KINDS}
    talk = {cls: host_of(number) for number, cls in chips.items()}
    places = {
        "chips.line": {"LineChip"},
        "core.chip": {"Chip"},
        "core.time.timebase": {"Time"},
        "parts.hosts.host": {"Host"},
        "parts.base.part": {"Part"},
    }
    others = several(chips)
    more = [host for found in others.values() for _, host in found]
    for cls in (*chips.values(), *kinds.values(), *talk.values(), *more):
        places.setdefault(cls.__module__.removeprefix("slewline."), set()).add(cls.__name__)
    imports = "\n".join(f"from ..{place} import {', '.join(sorted(names))}" for place, names in sorted(places.items()))
    adding = [(f'Literal["{number}"]', cls.__name__) for number, cls in chips.items()]
    making = [(f'Literal["{kind}"]', cls.__name__) for kind, cls in kinds.items()]
    hosting = [(cls.__name__, host.__name__) for cls, host in talk.items() if cls not in others]
    hosting += [("LineChip", "SerialHost"), ("Chip", "Host")]
    classes = [
        protocol("Adds", [*adding, ("type[C]", "C"), ("str", "Chip")], parameters("add")[1:], "part"),
        protocol("Makes", [*making, ("type[P]", "P"), ("str", "Part")], parameters("part")[1:], "kind"),
        "\nclass Hosts(Protocol):" + hosting_over(others, parameters("host")[1:]),
        protocol("Hosts", hosting, parameters("host")[1:], "*chips").removeprefix("\nclass Hosts(Protocol):\n"),
    ]
    return "\n".join([HEAD.format(imports=imports), *classes, ""])


def formatted(text: str) -> str:
    """Return a stub as formatted by ruff."""
    command = [sys.executable, "-m", "ruff", "format", "--stdin-filename", str(STUB), "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def blocks(page: str) -> list[str]:
    """Return the Python blocks of a page."""
    return re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text("utf-8"), re.MULTILINE | re.DOTALL)


def claims() -> str:
    """Return a program that asserts the class of every object that a bench returns by name."""
    lines = ["from typing import assert_type", "import slewline", "from slewline.core.chip import Chip"]
    lines += ["from slewline.parts.base.part import Part", "bench = slewline.Bench()"]
    lines += ['assert_type(bench["x"], Chip | Part)', 'assert_type(slewline.load("bench.toml")["x"], Chip | Part)']
    for number in PARTS:
        chip, host = chip_class(number), host_of(number)
        lines += [f"from {cls.__module__} import {cls.__name__}" for cls in (chip, host)]
        lines += [f'assert_type(bench.add("{number}"), {chip.__name__})']
        lines += [f'assert_type(bench.host(bench.add("{number}")), {host.__name__})']
        for channel in chip.sheet.channels[1:]:
            host = host_of(number, channel.name)
            lines += [f"from {host.__module__} import {host.__name__}"]
            lines += [f'assert_type(bench.host(bench.add("{number}"), over="{channel.name}"), {host.__name__})']
    for kind in KINDS:
        cls = part_class(kind)
        lines += [f"from {cls.__module__} import {cls.__name__}"]
        lines += [f'assert_type(bench.part("{kind}"), {cls.__name__})']
    return "\n".join(lines) + "\n"


def typed() -> int:
    """Check the types of examples, pages, and all objects that a bench returns; return the exit status of mypy."""
    with TemporaryDirectory() as folder:
        files = [str(path) for path in sorted((ROOT / "examples").glob("*.py"))]
        files.append(f"{folder}/claims.py")
        Path(files[-1]).write_text(claims(), "utf-8")
        for page in PAGES:
            for number, text in enumerate(blocks(page), 1):
                path = Path(folder) / f"{Path(page).stem.lower()}_{number}.py"
                eased = "".join(line for call, line in UNTOLD.items() if call in text)
                path.write_text(eased + text, "utf-8")
                files.append(str(path))
        command = [sys.executable, "-m", "mypy", "--strict", "--scripts-are-modules", *files]
        return subprocess.run(command, cwd=ROOT, check=False).returncode


def main() -> int:
    """Write the stub, or check it and the types of the examples; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; check the stub and the types of examples")
    text = formatted(stub())
    if not parser.parse_args().check:
        STUB.write_text(text, "utf-8")
        return 0
    if not STUB.is_file() or STUB.read_text("utf-8") != text:
        print(f"{STUB.relative_to(ROOT)} differs from the lists of chips and parts; run python tools/stubs.py")
        return 1
    return typed()


if __name__ == "__main__":
    sys.exit(main())
