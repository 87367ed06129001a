"""Words in the wrong order on a command line: the kind of each word, and the line that the user meant.

`kind_of` returns the kind of a word: a chip, a port, a file, a parameter ...  The name of an argument
determines the kinds that it takes (`TAKES`); a word that fits no argument belongs to an option for its
kind (`OPTIONS`).  A line that is in the right order, or cannot be put in order, is left alone.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

FILES = ("file", "recording", "bench file")
TAKES = {  # arguments by name, and the kinds of words that they take, preferred ones first; others take any word
    "chip": ("chip",),
    "port": ("port", "address"),
    "file": FILES,
    "files": FILES,
    "model": ("file",),
    "measured": ("recording", "file"),
    "what": (*FILES, "chip"),
    "target": (*FILES, "chip"),
    "parameters": ("parameter",),
}
OPTIONS = {  # kinds of words, and the options that take one: the first option that the command has
    "chip": ("--chip",),
    "port": ("--board", "--serial", "--port"),
    "address": ("--tcp", "--attach"),
    "file": ("--output",),
    "bench file": ("--bench",),
    "motor": ("--motor",),
    "parameter": ("--strap",),
}
INSTEAD = ("--bench", "--attach")  # of an argument
WRITES = {"tune"}  # commands whose --bench is written
ANY = "word"
DEVICE = re.compile(r"/dev/(tty|cu\.|pts/|serial/|rfcomm)|COM\d+$|[a-z][a-z0-9+]*://", re.IGNORECASE)
STREAM = re.compile(r"/dev/(std|fd/)|/proc/")
ADDRESS = re.compile(r"\d{2,5}|\[?[\w.:-]*\]?:\d{1,5}")
CLASS = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_][\w.]*")
PARAMETER = re.compile(r"[A-Za-z_][\w.]*=.*")
ENDING = re.compile(r"\.[A-Za-z][\w-]*")
RECORDINGS = (".csv", ".sr")


def misplaced(command: click.Command, ctx: click.Context, args: Sequence[str]) -> str | None:
    """Return a message with a misplaced word and a corrected line; None if no correction is found."""
    try:
        words, rest = parted(command, args)
    except LookupError:
        return None
    if message := exchanged(command, ctx, args, words):
        return message
    left = [(word, kind_of(command, word)) for word in words]
    kinds = dict(left)
    arguments = [each for each in command.get_params(ctx) if isinstance(each, click.Argument)]
    line: list[str] = []
    for number, argument in enumerate(arguments):
        takes = TAKES.get(argument.name or "")
        kind = kinds[words[number]] if number < len(words) else ANY
        is_open = argument.required or not (fits(kind, takes) or option_of(command, kind) in INSTEAD)
        if takes == TAKES["chip"] and left and is_file_of_chip(command, left):
            line.append(ending_of(left.pop(0)[0]) or shown(argument))
            continue
        taken = [fitting(left, takes)] if argument.nargs == 1 else [each for each in left if fits(each[1], takes)]
        found = [each for each in taken if each is not None]
        for each in found:
            left.remove(each)
        line += [shlex.quote(word) for word, _ in found] or [shown(argument)] * is_open
    if not left and line[: len(words)] == [shlex.quote(word) for word in words]:
        return None
    options = [option_of(command, kind) for _, kind in left]
    if any(not name or is_given(command, name, args) for name in options):
        return None
    if "--chip" in options and sum(kind == "chip" for kind in kinds.values()) > options.count("--chip"):
        return None  # the argument is a chip already
    at = next(place for place, word in enumerate(words) if line[place : place + 1] != [shlex.quote(word)])
    for option, (word, _) in zip(options, left, strict=True):
        line += [option, shlex.quote(word)]
    line += [shlex.quote(word) for word in rest]
    line += needed(command, ctx, line)
    message = describe(words[at], kinds[words[at]], arguments[at] if at < len(arguments) else None)
    return f"{message}; write:  slewline {ctx.info_name} {' '.join(line)}"


def exchanged(command: click.Command, ctx: click.Context, args: Sequence[str], words: Sequence[str]) -> str:
    """Return a message if an output file and a port are swapped, with the corrected line; otherwise ""."""
    written = next((each for each in command.params if "--output" in each.opts), None)
    first = next((each for each in command.get_params(ctx) if isinstance(each, click.Argument)), None)
    if written is None or first is None or TAKES.get(first.name or "") != TAKES["port"] or len(words) != 1:
        return ""
    at = next((at for at, word in enumerate(args[:-1]) if word in written.opts), None)
    if at is None or kind_of(command, args[at + 1]) not in TAKES["port"] or kind_of(command, words[0]) not in FILES:
        return ""
    places = {words[0]: args[at + 1], args[at + 1]: words[0]}
    line = " ".join(shlex.quote(places.get(word, word)) for word in args)
    return f"{words[0]!r} is a file, and {args[at + 1]!r} a port; write:  slewline {ctx.info_name} {line}"


def describe(word: str, kind: str, argument: click.Argument | None) -> str:
    """Return a text that names the kind of a misplaced word and the argument expected in its place."""
    if kind == ANY:
        return f"{word!r} is not {shown(argument)}" if argument is not None else f"{word!r} is one word too many"
    here = argument is not None and not fits(kind, TAKES.get(argument.name or ""))
    return f"{word!r} is {'an' if kind == 'address' else 'a'} {kind}" + (
        f", not {shown(argument)}" if here and argument else ""
    )


def is_file_of_chip(command: click.Command, words: Sequence[tuple[str, str]]) -> bool:
    """Return whether the first word is a file given in place of a chip.

    This is so if no word is a chip, and the command has no option for such a file.
    """
    kinds = [kind for _, kind in words]
    return kinds[0] in FILES and "chip" not in kinds and not option_of(command, kinds[0])


def parted(command: click.Command, args: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the words that are arguments, and the other words, which are options and their values.

    Raises:
        LookupError: the line has an option that the command does not have.
    """
    takes_value = {
        name: not (each.is_flag or each.count)
        for each in command.params
        if isinstance(each, click.Option)
        for name in (*each.opts, *each.secondary_opts, *getattr(each, "also", ()))
    }
    words: list[str] = []
    rest: list[str] = []
    before = ""
    for word in args:
        name = word.partition("=")[0] if word.startswith("--") else word[:2]
        is_value = takes_value.get(before, False) and not word.startswith("--")  # the F of --json F may be missing
        if is_value or word in ("-", "--") or not word.startswith("-"):
            (rest if is_value else words).append(word)
            before = ""
        elif name in takes_value:
            rest.append(word)
            before = word
        else:
            raise LookupError(name)
    return words, rest


def fits(kind: str, takes: Sequence[str] | None) -> bool:
    """Return whether an argument that takes the kinds `takes` (None: all) accepts a word of this kind."""
    return takes is None or kind == ANY or kind in takes


def fitting(words: Sequence[tuple[str, str]], takes: Sequence[str] | None) -> tuple[str, str] | None:
    """Return the word that suits an argument best, with its kind; None if no word suits it.

    Args:
        words: the words, each with its kind.
        takes: the kinds that the argument takes, most suitable first; None if it takes any word.  If no word
            is of these kinds, the first word of unknown kind is returned.
    """
    if takes is None:
        return words[0] if words else None
    known = [each for kind in takes for each in words if each[1] == kind]
    return next(iter([*known, *(each for each in words if each[1] == ANY)]), None)


def kind_of(command: click.Command, word: str) -> str:
    """Return the kind of a word on a command line, such as "chip" or "port"; "word" if it is unknown."""
    from ...chips import CATALOGUE

    path = Path(word)
    if word.lower() in CATALOGUE.ours:
        return ANY if path.is_file() else "chip"
    if STREAM.match(word) or word == "-":
        return "file"
    if DEVICE.match(word) or DEVICE.match(os.path.realpath(word)):
        return "port"
    if not path.exists():
        for kind, pattern in (("parameter", PARAMETER), ("address", ADDRESS), ("chip", CLASS)):
            if pattern.fullmatch(word):
                return kind
        if not ENDING.fullmatch(path.suffix):
            return "chip" if word.lower() in CATALOGUE.brought() else "motor" if is_motor(command, word) else ANY
    ending = path.suffix.lower()
    return "bench file" if ending == ".toml" else "recording" if ending in RECORDINGS else "file"


def is_motor(command: click.Command, word: str) -> bool:
    """Return whether a word is a motor from the list, and the command takes a motor."""
    if not has(command, "--motor"):
        return False
    from ...parts.motors.motors import MOTORS

    return word in MOTORS


def has(command: click.Command, option: str) -> bool:
    """Return whether a command has an option."""
    return any(option in each.opts for each in command.params)


def is_given(command: click.Command, option: str, args: Sequence[str]) -> bool:
    """Return whether an option is among the given words, under any of its names."""
    names = {name for each in command.params if option in each.opts for name in each.opts}
    return any(word.partition("=")[0] in names for word in args)


def option_of(command: click.Command, kind: str) -> str:
    """Return the option of a command that takes words of a kind; empty if the command has none."""
    names = OPTIONS.get(kind, ()) if not (kind == "bench file" and command.name in WRITES) else ()
    several = {name for each in command.params if getattr(each, "multiple", False) for name in each.opts}
    return next((name for name in names if has(command, name) and (kind == "parameter" or name not in several)), "")


def ending_of(path: str) -> str:
    """Return the chip that a file extension names; empty if it names none."""
    from ...chips import CATALOGUE

    ending = Path(path).suffix[1:].lower()
    return ending if ending in CATALOGUE.names() else ""


def shown(argument: click.Argument) -> str:
    """Return the name of an argument, as in the usage line."""
    return argument.human_readable_name.strip("[].").partition(" ")[0]


def needed(command: click.Command, ctx: click.Context, line: Sequence[str]) -> Iterator[str]:
    """Yield the required options that the line lacks, each with its metavar."""
    for each in command.get_params(ctx):
        if isinstance(each, click.Option) and each.required and not is_given(command, each.opts[0], line):
            yield f"{each.opts[0]} {each.make_metavar(ctx)}"
