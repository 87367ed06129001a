"""Backup of a module's content in files: a program in a module is only replaced after it has been saved.

A file is written completely or not at all, and an existing file is only replaced if that is requested.
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
from .readers import Report
from .restore import STORED_BYTE_S, ProgramText, Restore, can_store
from .writing import WRITERS, send

IMAGE = ".ihx"


class Unfinished(ModuleFailure):
    """An error in the middle of a task; the message states the module's current content, and how to continue."""


# ---------------------------------------------------------------------------------------------------------------- pull
def pull(
    module: Module,
    path: str | PathLike[str],
    *,
    base: int | None = None,
    recall: bool = False,
    replace: bool = False,
    report: Report = lambda _text: None,
) -> ModuleContents:
    """Save the content of a module to a file, and return the content.

    Args:
        path: the file to be written.
        base: the address at which the program begins, in a memory with addresses; None: 0.
        recall: whether to save the program in the EEPROM as well, to a separate file; that program briefly
            replaces the program in RAM, which is then restored and verified.
        replace: whether existing files may be replaced.
        report: called with progress messages.

    Raises:
        UsageError: a file exists, or cannot be written; or `recall` is True, but the part has no EEPROM.
        Unfinished: the program that was in RAM could not be restored; it is in the file `path`.
        ModuleFailure: the module could not be read.
    """
    own, other = Path(path), beside(path, "eeprom")
    check_recall(module.speech.sheet, recall)
    for each in (own, *([other] if recall else [])):
        check_new(each, replace)
    contents = read_contents(module, base, report)
    save(own, contents, report)
    if recall:
        _pull_other(module, contents, other, report)
    return contents


def _pull_other(module: Module, contents: ModuleContents, path: Path, report: Report) -> None:
    """Save the EEPROM's program, if there is one, to the file `path`, and restore the program in RAM."""
    (row,) = contents.sheet.acting("recall")
    with _putting_back(module, contents, report) as restore:
        try:
            restore.recall()
        except RefusedCommand as refused:
            report(
                f"{row.form} was answered with {refused.code}: {refused.description}; no program was saved from the "
                "EEPROM"
            )
            return
        save(path, read_contents(module), report)


@contextmanager
def _putting_back(module: Module, contents: ModuleContents, report: Report) -> Iterator[Restore]:
    """Restore a module's program at the end of a `with` block, even after an error, and verify the program."""
    wanted = ProgramText.read(contents.text, contents.sheet, module.name)
    restore = Restore(module, wanted, contents, report)
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
                "\n".join(whys) + f"\nthe old program was not restored.  Contents of {module.name}, as far as its "
                f"answers show: {restore.status}.  The file holds the program: slewline push restores it"
            ) from None


def _put_back(restore: Restore) -> None:
    """Send the old program, unless the module already holds it; if the module cannot be read, send it anyway."""
    try:
        restore.contents = read_contents(restore.module)
    except PortLost:
        raise
    except ModuleFailure:
        restore.is_known = False
    if not restore.is_there:
        restore.report("restoring the old program ...")
        send(restore)


def _why(failure: BaseException) -> str:
    return "interrupted" if isinstance(failure, KeyboardInterrupt) else str(failure)


def check_recall(sheet: Sheet, recall: bool) -> None:
    """Check that a part stores a second program in an EEPROM, if `recall` is True.

    Raises:
        UsageError: `recall` is True, but the part stores no second program.
    """
    if recall and not sheet.acting("recall"):
        raise UsageError(f"--eeprom: the {sheet.part.upper()} has one program, in its memory; leave out --eeprom")


# ---------------------------------------------------------------------------------------------------------------- push
def push(
    module: Module,
    wanted: ProgramText,
    path: str | PathLike[str],
    *,
    store: bool = False,
    keep: str | PathLike[str] | None = None,
    pace: float = STORED_BYTE_S,
    report: Report = lambda _text: None,
) -> None:
    """Send a program to a module, verify it by reading it back and, if `store` is True, store it in the EEPROM.

    The module's old program is saved first, unless the module already holds the new program, or holds only
    the beginning of it after an interrupted push: that push has already saved the old program.

    Args:
        path: the file with the program.
        store: whether to store the program in the EEPROM.
        keep: the file for the old program; None: a new file next to `path`.
        pace: the pause after each character, in seconds, for a memory with addresses.
        report: called with progress messages.

    Raises:
        UsageError: the old program cannot be saved; or `store` is True, but the part cannot store.
        MotionRefused: a command outside the program may step the motor.
        Unfinished: the push failed or was interrupted; the message describes the module's content.
        ModuleFailure: the module could not be read; its program is unchanged.
    """
    check_store(wanted.sheet, store)
    wanted.check_motion(module, str(path))
    contents = read_contents(module, wanted.base, report)
    restore = Restore(module, wanted, contents, report, pace)
    kept = keep_before(restore, contents, path, keep, report)
    try:
        send(restore)
        if store:
            restore.store()
    except (ModuleFailure, KeyboardInterrupt) as failure:
        raise Unfinished(
            f"{_why(failure)}\ncontents of {module.name}, as far as its answers show: {restore.status}"
            f"{'; ' + kept if kept else ''}\nto continue, repeat the same command"
        ) from None
    report(restore.status)


def keep_before(
    restore: Restore,
    contents: ModuleContents,
    path: str | PathLike[str],
    keep: str | PathLike[str] | None,
    report: Report,
) -> str:
    """Save the content of a module before a push, unless that is unnecessary.

    It is unnecessary if the module already holds the program to be pushed, or if it holds only the beginning
    of this program after an interrupted push, and the file in which that push saved the old content exists.

    Returns:
        A text that names the file with the old content; "" if the content is the program to be pushed.

    Raises:
        UsageError: the content cannot be saved.
    """
    if restore.is_there:
        report("the module already holds this program")
        return ""
    if restore.was_cut and (earlier := beside(path, "before") if keep is None else Path(keep)).is_file():
        found = f"the module holds the beginning of this program ({contents.size})"
        report(f"{found}: left by an interrupted push, which now continues")
        return f"the old program is in {earlier}"
    return f"the old program is in {save_beside(path, contents, keep, report)}"


def check_push(sheet: Sheet) -> None:
    """Check that a program can be sent to a part, and can be verified afterwards.

    Raises:
        UsageError: a program cannot be sent, or cannot be verified.
    """
    if not any(isinstance(channel, (*WRITERS,)) for channel in sheet.channels):
        part = sheet.part.upper()
        raise UsageError(
            f"push: an adapter does not show whether the {part} is in program entry, so a move might be executed "
            "instead of stored; allowed: parts with a serial line; for this part, switch the motor off, and type in "
            "the program with slewline terminal"
        )


def check_store(sheet: Sheet, store: bool) -> None:
    """Check that a part can store its program in an EEPROM, if `store` is True.

    Raises:
        UsageError: `store` is True, but the part cannot store its program.
    """
    if store and not can_store(sheet):
        raise UsageError(
            f"--store: the {sheet.part.upper()} has no command for this, because its program is already in an external "
            "memory; leave out --store"
        )


# --------------------------------------------------------------------------------------------------------------- files
def beside(path: str | PathLike[str], what: str) -> Path:
    """Return the path of a file next to `path`, with `what` in its name.

    For weld.gs-c200s and "before", this is weld.before.gs-c200s.
    """
    own = Path(path)
    return own.with_name(f"{own.stem}.{what}{own.suffix}")


def free(path: str | PathLike[str], what: str, same: str | None = None) -> Path:
    """Return the path of a new file next to `path`, numbered if the usual one exists.

    If the usual path exists, `what` is followed by a number, which is increased until the path is free.

    Args:
        same: unless None, the path of an existing file with exactly this text counts as free, too.
    """
    for number in count(1):
        found = beside(path, what if number == 1 else f"{what}-{number}")
        if not os.path.lexists(found) or (same is not None and has(found, same)):
            return found
    raise AssertionError


def has(path: Path, text: str) -> bool:
    """Return whether `path` is a regular file that contains exactly the given text."""
    return path.is_file() and path.stat().st_size == len(text) and read_file(path) == text.encode("latin-1")


def check_new(path: Path, replace: bool | None) -> None:
    """Check that a file does not exist, unless it may be replaced.

    Args:
        replace: whether the file may be replaced; None: it may not, and no option allows it.

    Raises:
        UsageError: the file exists, and may not be replaced.
    """
    if path.is_file() and not replace:
        remedy = "name a new file" + ", or give --replace" * (replace is not None)
        raise UsageError(f"{path}: this file exists; {remedy}")


def save(path: Path, contents: ModuleContents, report: Report) -> None:
    """Write a module's content to a file as text, and also as an image if text cannot represent all of it.

    The image is in a second file next to the first one.

    Raises:
        UsageError: a file cannot be written.
    """
    with WholeFile(path, durable=True) as file:
        file.write(contents.text.encode("latin-1"))
    report(f"wrote {path}: {contents.size}")
    if unsaid := contents.unsaid:
        image = path.with_name(path.name + IMAGE)
        with WholeFile(image, durable=True) as file:
            file.write(to_hex(contents.image).encode("ascii"))
        report(f"{path} cannot represent all of the program: {unsaid}; the bytes of the program are in {image}")


def save_beside(
    path: str | PathLike[str], contents: ModuleContents, keep: str | PathLike[str] | None, report: Report
) -> Path:
    """Save a module's old content before a push, to `keep` or, if None, next to `path`; return the path used.

    Raises:
        UsageError: the file exists with other content, or cannot be written.
    """
    text = contents.text
    found = free(path, "before", text) if keep is None else Path(keep)
    if has(found, text):
        report(f"the old program is already in {found}")
        return found
    check_new(found, replace=None)
    earlier = sorted(found.parent.glob(f"{beside(path, 'before*').name}")) if keep is None else []
    save(found, contents, report)
    if earlier:
        names = ", ".join(map(str, earlier))
        report(f"{names}: saved by earlier pushes, one of which may have left an incomplete program in {found}")
    return found
