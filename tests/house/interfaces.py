"""The interfaces that programs of users and files of users rely on, as lines of text, one for each name.

    python -m tests.house.interfaces > tests/house/interfaces.txt        keep the present ones

Names of the public API with their arguments, attributes of objects, options of parts, commands with their options,
codes of findings and of lint, keys of bench files, requests of the control port.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import click

import slewline
import slewline.build
from slewline.bench.files.tables import Tables, keys_of
from slewline.chips import PARTS, sheet_of
from slewline.cli.commands import cli
from slewline.links.control.requests import REQUESTS
from slewline.parts import KINDS, part_class
from tests.system.test_faces import everything, public

SRC = Path(slewline.__file__).parent
MODULES = (
    *("slewline.errors", "slewline.testing", "slewline.testing.aio", "slewline.testing.ports"),
    *("slewline.links.clients.chipset_host", "slewline.links.clients.chipset_port", "slewline.links.clients.card_port"),
    "slewline.links.clients.control_client",
)
CODED = {"finding": 0, "report": 2, "warn": 1}  # calls of which an argument is a code, and its place


def arguments(thing: object) -> str:
    """Return the arguments of a function by name, with those that may be left out in brackets."""
    try:
        parameters = inspect.signature(thing).parameters.values()  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return ""
    names = (p.name if p.default is p.empty and p.kind is not p.VAR_KEYWORD else f"[{p.name}]" for p in parameters)
    return f"({', '.join(names)})"


def api() -> Iterator[str]:
    """Yield the names that modules export, and members of classes."""
    for module in (slewline, slewline.build, *map(import_module, MODULES)):
        for name in getattr(module, "__all__", None) or [name for name in dir(module) if name[0].isupper()]:
            thing = getattr(module, name)
            yield f"api {module.__name__}.{name}{arguments(thing) if callable(thing) else ''}"


def attributes() -> Iterator[str]:
    """Yield the public attributes of objects of each class, methods with their arguments."""
    for thing in everything():
        for name in public(thing):
            owner = next((cls for cls in type(thing).__mro__ if name in vars(cls)), type(thing))
            called = arguments(getattr(thing, name)) if inspect.isfunction(vars(owner).get(name)) else ""
            yield f"attribute {owner.__name__}.{name}{called}"


def options() -> Iterator[str]:
    """Yield the options of chips and parts."""
    for part in PARTS:
        yield from (f"option {part} {option.name}" for option in sheet_of(part).options)
    for kind in KINDS:
        yield from (f"option {kind} {option.name}" for option in part_class(kind).options)


def commands(command: click.Command, path: str, above: click.Context | None = None) -> Iterator[str]:
    """Yield a command, its arguments and options, and those of commands below it."""
    context = click.Context(command, parent=above, **command.context_settings)
    for parameter in command.get_params(context):
        yield f"command {path} {' '.join(sorted([*parameter.opts, *parameter.secondary_opts]))}"
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            yield f"command {path} {name}"
            if (below := command.get_command(context, name)) is not None:
                yield from commands(below, f"{path} {name}", context)


def codes() -> Iterator[str]:
    """Yield the codes of findings and of problems of programs, as far as they are written where they are reported."""
    for path in sorted(SRC.rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text("utf-8"))):
            if not isinstance(call, ast.Call):
                continue
            name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
            for argument in call.args[:3] if name.lstrip("_") in CODED else ():
                if isinstance(argument, ast.Constant) and isinstance(argument.value, str) and " " not in argument.value:
                    yield f"code {argument.value}"


def files() -> Iterator[str]:
    """Yield the keys of bench files, and those of requests of the control port."""
    for table in Tables.__struct_encode_fields__:
        yield from (f"bench file [{table}] {key}" for key in keys_of([table]))
    for row in REQUESTS:
        yield from (f"control {row.do} {key.name}" for key in row.keys)
        yield from (f"control {row.do} reply {key.name}" for key in row.reply)


def present() -> list[str]:
    """Return all lines, sorted."""
    return sorted({*api(), *attributes(), *options(), *commands(cli, "slewline"), *codes(), *files()})


if __name__ == "__main__":
    print("\n".join(present()))
