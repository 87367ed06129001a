"""Files of a module: what it holds is saved before anything else, and a program is put back only over what was saved.

A file appears whole or not at all, and none is replaced unless that is asked for.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from os import PathLike
from pathlib import Path

from ...core.datasheet.table import Sheet
from ...core.memory.image import to_hex
from ...errors import SlewlineError, UsageError
from ...gate import read_file
from ...record.whole_file import WholeFile
from ..failures import ModuleFailure, PortLost, RefusedCommand
from ..module import Module
from .contents import ModuleContents, read_contents
from .readers import Say
from .restore import STORED_BYTE_S, ProgramText, Restore, can_store
from .writing import WRITERS, send

IMAGE = ".ihx"


class Unfinished(ModuleFailure):
    """Something went wrong on the way; the message says what the module holds now, and how to go on."""


# ---------------------------------------------------------------------------------------------------------------- pull
def pull(
    module: Module,
    path: str | PathLike[str],
    *,
    base: int | None = None,
    recall: bool = False,
    replace: bool = False,
    say: Say = lambda _text: None,
) -> ModuleContents:
    """Save what a module holds into a file, and return it.

    Args:
        path: a new file.
        base: where the program begins, in a memory with addresses.
        recall: save also the program that the module keeps without power, into a file of its own; that takes the place
            of the other one for a moment, which is put back, and verified.
        replace: the file may be there already.
        say: told what is done.

    Raises:
        UsageError: the file is there, or cannot be written; the part keeps no other program.
        Unfinished: the other program was not put back; it is in the file.
        ModuleFailure: the module could not be read.
    """
    own, other = Path(path), beside(path, "eeprom")
    check_recall(module.speech.sheet, recall)
    for each in (own, *([other] if recall else [])):
        check_new(each, replace)
    contents = read_contents(module, base, say)
    save(own, contents, say)
    if recall:
        _pull_other(module, contents, other, say)
    return contents


def _pull_other(module: Module, contents: ModuleContents, path: Path, say: Say) -> None:
    """Save the program that is kept without power, and put the other one back."""
    (row,) = contents.sheet.acting("recall")
    with _putting_back(module, contents, say) as restore:
        try:
            restore.recall()
        except RefusedCommand as refused:
            say(f"{row.form} was answered with {refused.code}: {refused.says}; there is no other program to save")
            return
        save(path, read_contents(module), say)


@contextmanager
def _putting_back(module: Module, contents: ModuleContents, say: Say) -> Iterator[Restore]:
    """Put a program back into a module at the end, whatever happens meanwhile; it is verified by its listing."""
    wanted = ProgramText.read(contents.text, contents.sheet, module.name)
    restore = Restore(module, wanted, contents, say)
    began = ""
    try:
        yield restore
    except (SlewlineError, KeyboardInterrupt) as failure:
        began = _why(failure)
        raise
    finally:
        try:
            _put_back(restore)
        except (ModuleFailure, KeyboardInterrupt) as failure:
            whys = dict.fromkeys(filter(None, (began, _why(failure))))
            raise Unfinished(
                "\n".join(whys) + f"\nthe program that was there is not back.  What {module.name} holds, as far as it "
                f"has answered: {restore.stands}.  The file has the program: slewline push puts it back"
            ) from None


def _put_back(restore: Restore) -> None:
    """Send a program, unless the module holds it; what it holds is not known if it cannot be read."""
    try:
        restore.contents = read_contents(restore.module)
    except PortLost:
        raise
    except ModuleFailure:
        restore.is_known = False
    if not restore.is_there:
        restore.say("put back what was there ...")
        send(restore)


def _why(failure: BaseException) -> str:
    return "interrupted" if isinstance(failure, KeyboardInterrupt) else str(failure)


def check_recall(sheet: Sheet, recall: bool) -> None:
    """Check that a part keeps a second program, if that is asked for.

    Raises:
        UsageError: it does not.
    """
    if recall and not sheet.acting("recall"):
        raise UsageError(f"--eeprom: the {sheet.part.upper()} has one program, in its memory; leave it out")


# ---------------------------------------------------------------------------------------------------------------- push
def push(
    module: Module,
    wanted: ProgramText,
    path: str | PathLike[str],
    *,
    store: bool = False,
    keep: str | PathLike[str] | None = None,
    pace: float = STORED_BYTE_S,
    say: Say = lambda _text: None,
) -> None:
    """Send a program to a module, verify it by its listing, and only then let the module keep it without power.

    What was there is saved first, unless it is the beginning of the same program, which an earlier push has left.

    Args:
        path: the file that the program comes from.
        store: let the module keep it without power.
        keep: where to save what was there; None: a new file beside `path`.
        pace: seconds from one character to the next that goes into a memory with addresses.
        say: told what is done.

    Raises:
        UsageError: what was there cannot be saved, or the part stores nothing.
        MotionRefused: a command outside the program may make a step.
        Unfinished: the program was not sent whole, or not verified; what the module holds is said.
        ModuleFailure: the module could not be read; nothing was sent.
    """
    check_store(wanted.sheet, store)
    wanted.check_motion(module, str(path))
    contents = read_contents(module, wanted.base, say)
    restore = Restore(module, wanted, contents, say, pace)
    kept = keep_before(restore, contents, path, keep, say)
    try:
        send(restore)
        if store:
            restore.store()
    except (ModuleFailure, KeyboardInterrupt) as failure:
        raise Unfinished(
            f"{_why(failure)}\nwhat {module.name} holds, as far as it has answered: {restore.stands}"
            f"{'; ' + kept if kept else ''}\nto go on, call the same again"
        ) from None
    say(restore.stands)


def keep_before(
    restore: Restore,
    contents: ModuleContents,
    path: str | PathLike[str],
    keep: str | PathLike[str] | None,
    say: Say,
) -> str:
    """Save what a module holds before a push, unless that is the pushed program or its beginning, which is cut off.

    Returns:
        Where what was there is, in words; "" if it is the pushed program.

    Raises:
        UsageError: it cannot be saved.
    """
    if restore.is_there:
        say("it holds this program already")
        return ""
    if restore.was_cut and (earlier := beside(path, "before") if keep is None else Path(keep)).is_file():
        say(f"it holds the beginning of this program, {contents.size}: an earlier push was cut, which goes on")
        return f"what was there is in {earlier}"
    return f"what was there is in {save_beside(path, contents, keep, say)}"


def check_push(sheet: Sheet) -> None:
    """Check that a program can be sent to a part, and verified.

    Raises:
        UsageError: it cannot.
    """
    if not any(isinstance(channel, (*WRITERS,)) for channel in sheet.channels):
        part = sheet.part.upper()
        raise UsageError(
            f"push: nothing shows through an adapter whether program entry of the {part} is open, so that a move might "
            "be made instead of stored, and what cannot be verified is not sent; allowed parts with a serial line; "
            "switch the motor off and enter the program by hand, with slewline terminal"
        )


def check_store(sheet: Sheet, store: bool) -> None:
    """Check that a part can keep its program without power, if that is asked for.

    Raises:
        UsageError: it cannot.
    """
    if store and not can_store(sheet):
        raise UsageError(
            f"--store: the {sheet.part.upper()} has no such command; its program is in a memory beside it; leave it out"
        )


# --------------------------------------------------------------------------------------------------------------- files
def beside(path: str | PathLike[str], what: str) -> Path:
    """Return the name of a file beside another one: weld.before.gs-c200s beside weld.gs-c200s."""
    own = Path(path)
    return own.with_name(f"{own.stem}.{what}{own.suffix}")


def free(path: str | PathLike[str], what: str, same: str | None = None) -> Path:
    """Return the name of a file beside another one that is not taken, or has a text already.

    Args:
        same: the text.
    """
    for number in count(1):
        found = beside(path, what if number == 1 else f"{what}-{number}")
        if not os.path.lexists(found) or (same is not None and has(found, same)):
            return found
    raise AssertionError


def has(path: Path, text: str) -> bool:
    """Return whether a file is there, and has this text; what is no regular file, or longer, has not."""
    return path.is_file() and path.stat().st_size == len(text) and read_file(path) == text.encode("latin-1")


def check_new(path: Path, replace: bool | None) -> None:
    """Check that a file is not there, unless it may be replaced.

    Args:
        replace: it may; None: nothing is asked for that would let it be.

    Raises:
        UsageError: it is there.
    """
    if path.is_file() and not replace:
        remedy = "name a new file" + ", or give --replace" * (replace is not None)
        raise UsageError(f"{path}: this file exists; {remedy}")


def save(path: Path, contents: ModuleContents, say: Say) -> None:
    """Write what a module holds into a file, whole; beside it an image, if the text cannot say all of it.

    Raises:
        UsageError: it cannot be written.
    """
    with WholeFile(path, durable=True) as file:
        file.write(contents.text.encode("latin-1"))
    say(f"wrote {path}: {contents.size}")
    if unsaid := contents.unsaid:
        image = path.with_name(path.name + IMAGE)
        with WholeFile(image, durable=True) as file:
            file.write(to_hex(contents.image).encode("ascii"))
        say(f"{path} does not say all of the program: {unsaid}; its bytes are in {image}")


def save_beside(
    path: str | PathLike[str], contents: ModuleContents, keep: str | PathLike[str] | None, say: Say
) -> Path:
    """Save what was in a module before a push; return where.

    Raises:
        UsageError: the file is there with something else in it, or cannot be written.
    """
    text = contents.text
    found = free(path, "before", text) if keep is None else Path(keep)
    if has(found, text):
        say(f"{found} has what is there")
        return found
    check_new(found, replace=None)
    earlier = sorted(found.parent.glob(f"{beside(path, 'before*').name}")) if keep is None else []
    save(found, contents, say)
    if earlier:
        names = ", ".join(map(str, earlier))
        say(f"{names}: of earlier pushes; what is in {found} may be what one of them has left half sent")
    return found
