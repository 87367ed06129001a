"""Writing of a program into a module, with verification; the motor never steps unless motion is allowed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import zip_longest
from types import MappingProxyType

from ...core.datasheet.channel import AdaptiveLine, Channel, SerialLine, row_for
from ...core.datasheet.table import Sheet
from ...language.assemble import units
from ...language.dialect import dialect_of
from ...language.statements import Statement
from ..failures import DamagedAnswer, ListingDiffers, ModuleFailure, MotionRefused, NoAnswer
from ..module import Module
from ..spoken import CR
from .contents import harmless_end
from .readers import MemoryReader, read_listing
from .restore import ROUNDS, Restore, can_store

QUIET_S = 0.4  # silence without an answer to a query: program entry is open


# ---------------------------------------------------------------------------------------------------- entry by lines
def write_listed(restore: Restore) -> None:
    """Enter a program line by line, verify it by the module's listing, and end program entry."""
    for left in reversed(range(ROUNDS)):
        try:
            _enter(restore)
            _compare(restore)
            break
        except (NoAnswer, DamagedAnswer, ListingDiffers) as failure:
            if not left or (isinstance(failure, NoAnswer) and _is_silent(restore.module)):
                raise
            restore.module.transcript.note(f"{failure}; the program is entered again")
    _leave(restore)


def _is_silent(module: Module) -> bool:
    try:
        module.ask(module.speech.probe)
    except ModuleFailure:
        return True
    return False


def _enter(restore: Restore) -> None:
    """Open program entry, and send the instructions."""
    module, sheet, lines = restore.module, restore.sheet, restore.wanted.program
    whole = len(lines)
    assert sheet.enter is not None  # noqa: S101  # a program text has been read for it
    restore.status = f"its program may be erased ({sheet.enter.form}); {_kept(sheet)}"
    for left in reversed(range(ROUNDS)):
        try:
            module.ask(sheet.enter.form)
            break
        except (NoAnswer, DamagedAnswer):
            if not left:
                raise
    for number, line in enumerate(lines):
        restore.status = f"it holds {number} of {whole} instructions; program entry is open; {_kept(sheet)}"
        _surely(restore, line.text, lines[: number + 1])


def _surely(restore: Restore, text: str, expected: Sequence[Statement]) -> None:
    """Send a line; if its answer is lost, read the listing, and send the line again if it was not accepted.

    Args:
        expected: all instructions that the module lists after it has accepted the line; the last of them is
            the instruction in the line.
    """
    for left in reversed(range(3)):
        try:
            restore.module.ask(text)
            return
        except (NoAnswer, DamagedAnswer):
            if not left:
                raise
            found = read_listing(restore.module)
            before = b"".join(each.row.pack(each.values) for each in expected)
            if found.stored == before:
                return
            less = b"".join(each.row.pack(each.values) for each in expected[:-1])
            if found.stored != less:
                raise


def _kept(sheet: Sheet) -> str:
    return "the program in its EEPROM is unchanged" if can_store(sheet) else "no other memory was changed"


def _compare(restore: Restore) -> None:
    """Check that the module lists exactly the program that was sent.

    Raises:
        ListingDiffers: an instruction is listed differently.
    """
    found = read_listing(restore.module)
    if found.stored != restore.wanted.stored:
        spell = dialect_of(restore.sheet).spell
        sent = [spell(each.row, each.values) for each in restore.wanted.program]
        pairs = zip_longest(found.program, sent, fillvalue="nothing")
        at, (one, other) = next((n, pair) for n, pair in enumerate(pairs, 1) if pair[0] != pair[1])
        raise ListingDiffers(
            f"{restore.module.name}: instruction {at} is listed as {one}, but was sent as {other}; the program was not "
            "stored; check the line for noise, and push again"
        )
    restore.report(f"verified: {len(found.program)} instructions")


def _leave(restore: Restore) -> None:
    """End program entry, if the part has a command that does so without running the program."""
    sheet, module = restore.sheet, restore.module
    memory = " in its RAM" if can_store(sheet) else ""
    outcome = f"the module holds the program (verified){memory}; {_kept(sheet)}"
    restore.status = f"{outcome}; program entry is open"
    end = harmless_end(sheet)
    if end is None:
        (only,) = sheet.leave
        restore.report(
            f"program entry is open: command {only.form} ends it, and runs the program; a power cycle also ends it, "
            "but a program that is not stored is then lost"
        )
        return
    try:
        module.ask(end.form)
    except (NoAnswer, DamagedAnswer):
        module.ask(end.form)  # a second one has no effect
    restore.status = outcome


# ------------------------------------------------------------------------------------------------- into a memory
class MemoryWriter:
    """A writer of a program into an addressed memory, in groups of instructions, the last group first.

    Every group except the first begins with an instruction that may step the motor.

    If program entry were not open, the module would execute the instructions.  So two queries are sent
    before an instruction that may step the motor.  If entry is not open, the module answers the queries.  If
    entry is open, the queries are stored where the preceding group will end; that group is written later,
    and overwrites them.  If the first group needs queries, these are stored at the end of the memory,
    because its addresses wrap round; the memory must be erased there.
    """

    def __init__(self, restore: Restore) -> None:
        self.restore, self.module, self.wanted = restore, restore.module, restore.wanted
        self.sheet = restore.sheet
        self.reader = MemoryReader(self.module, restore.report)
        self.question = self.module.speech.framed(self.module.speech.probe) * 2
        self.groups = _groups(self.wanted.program)

    def write(self) -> None:
        """Write the missing or wrong groups, and read them back, until the whole program is stored.

        Raises:
            ListingDiffers: after the last attempt, parts of the program still read back wrongly.
            MotionRefused: the first instruction may step the motor, but there is no room for queries before it.
        """
        whole = f"of {len(self.wanted.stored)} {units(self.sheet)} from {self.wanted.base} on"
        wrong = self.closed({n for n, group in enumerate(self.groups) if not self.was_read(group)})
        if 0 in wrong:
            self.check_room()
        for _ in range(ROUNDS):
            if not wrong:
                self.restore.status = "the module holds the program (verified)"
                self.restore.report(f"verified: {len(self.wanted.program)} instructions")
                return
            missed = set()
            for number in sorted(wrong, reverse=True):
                self.restore.status = f"{whole}, some are old and some new; program entry may be open"
                if not self.is_written(self.groups[number]):
                    missed.add(number)
            wrong = self.differing(missed)
        raise ListingDiffers(
            f"{self.module.name}: {whole}, {len(wrong)} parts do not read back as sent; check that the memory "
            "can be written.  For an EEPROM slower than 20 ms per byte, give --pace"
        )

    def was_read(self, group: Sequence[Statement]) -> bool:
        """Return whether the instructions of a group were in the memory when the memory was first read."""
        present = self.restore.contents
        begin, end = group[0].address - present.base, group[-1].end - present.base
        return begin >= 0 and present.stored[begin:end] == b"".join(map(_bytes, group))

    def differing(self, missed: set[int]) -> set[int]:
        """Return the numbers of the groups to write again: missed, wrong, or overwritten by queries.

        `missed` are the groups whose writing failed.  They are not read, because they may be erased, which takes
        a long time to detect.
        """
        read = (number for number in range(len(self.groups)) if number not in missed)
        return self.closed(missed | {number for number in read if not self.reads_back(self.groups[number])})

    def reads_back(self, group: Sequence[Statement]) -> bool:
        """Read a group's instructions from the memory; return whether they all match the program."""
        try:
            return all(self.reader.instruction(each.address) == _bytes(each) for each in group)
        except (NoAnswer, DamagedAnswer, ListingDiffers):
            return False

    def closed(self, wrong: set[int]) -> set[int]:
        """Return the numbers of the groups to write again if the groups in `wrong` are written again.

        The queries sent before a group overwrite the bytes just before it, which belong to earlier groups.  Those
        groups are added to `wrong`, and so are the groups that the queries before them overwrite in turn.
        """
        for number in range(len(self.groups) - 1, 0, -1):
            if number in wrong and self.is_checked(self.groups[number]):
                reach = self.groups[number][0].address - len(self.question)
                wrong |= {at for at in range(number) if self.groups[at][-1].end > reach}
        return wrong

    def is_checked(self, group: Sequence[Statement]) -> bool:
        """Return whether a group may only be sent after a check that program entry is open."""
        return group[0].row.may_step and not self.module.may_move

    def check_room(self) -> None:
        """Check that any queries before the first group would only overwrite erased bytes at the memory's end.

        Raises:
            MotionRefused: they would overwrite other data.
        """
        first = self.groups[0][0]
        begin = (first.address - len(self.question)) % self.sheet.buffer_bytes
        at_end = begin > first.address
        if not self.is_checked(self.groups[0]):
            return
        if at_end and self.reader.instruction(begin) in (b"", self.question[: len(self.question) // 2]):
            return
        raise MotionRefused(
            f"{self.module.name}: the program begins with {first.text}, which would step the motor if the module "
            f"missed the start of program entry, and there is no room at {begin} for a query that would "
            "reveal this; no command was sent; begin with a harmless command, such as one that sets a register, or "
            "allow motion with --move"
        )

    def is_written(self, group: Sequence[Statement]) -> bool:
        """Write a group of instructions; return whether the module has stored as many characters as were sent."""
        try:
            self.write_group(group)
        except (NoAnswer, DamagedAnswer) as failure:
            self.module.transcript.note(f"instructions written again: {failure}")
            self.end_entry()
            return False
        self.end_entry()
        return self.pointer == group[-1].end

    @property
    def pointer(self) -> int:
        """Address in the memory pointer of the module, which is queried each time."""
        questions = self.module.speech.questions.items()
        return int(self.module.value(next(n for n, (ask, _) in questions if ask[-1] == self.reader.pointer.form)))

    def write_group(self, group: Sequence[Statement]) -> None:
        """Write a group of instructions, if necessary after a check that program entry is open."""
        assert self.sheet.enter is not None  # noqa: S101  # a program text has been read for it
        checked = self.is_checked(group)
        begin = (group[0].address - len(self.question) * checked) % self.sheet.buffer_bytes
        self.module.ask(f"{self.reader.pointer.form} {begin}")
        if self.pointer != begin:
            raise DamagedAnswer(f"{self.module.name}: the pointer is not at {begin}")
        self.put(self.module.speech.framed(self.sheet.enter.form))
        if checked:
            self.put(self.question)
            if self.module.listen(QUIET_S):
                raise DamagedAnswer(f"{self.module.name}: program entry is not open")
        for each in group:
            self.put(_bytes(each))

    def put(self, data: bytes) -> None:
        """Send characters, each followed by a pause in which the memory stores it."""
        for byte in data:
            self.module.send(bytes([byte]))
            self.module.port.pause(self.restore.pace + self.module.speech.character_s)

    def end_entry(self) -> None:
        """End program entry; repeat this until the module answers a query."""
        (leave,) = self.sheet.leave
        for left in reversed(range(ROUNDS)):
            self.put(leave.form.encode("ascii"))
            try:
                self.module.ask(self.module.speech.probe)
                return
            except NoAnswer:
                if not left:
                    raise
                self.put(CR)


def _bytes(statement: Statement) -> bytes:
    return statement.text.encode("latin-1") + CR


def _groups(program: Sequence[Statement]) -> list[list[Statement]]:
    """Split a program into groups: a new group begins at every instruction that may step the motor."""
    groups: list[list[Statement]] = []
    for each in program:
        if not groups or each.row.may_step:
            groups.append([])
        groups[-1].append(each)
    return groups


def write_memory(restore: Restore) -> None:
    """Write a program into an addressed memory, and set the memory pointer back to its earlier address."""
    writer = MemoryWriter(restore)
    pointer = writer.pointer
    writer.write()
    restore.module.ask(f"{writer.reader.pointer.form} {pointer}")


def send(restore: Restore) -> None:
    """Send a program and the commands before and after it; skip the program if the module already holds it.

    The commands and the program are verified as far as possible.

    Raises:
        ModuleFailure: a command failed; `restore.status` describes the content of the module.
    """
    if restore.wanted.before:
        restore.status = f"some registers may be set already; {restore.holds}"
    for each in restore.wanted.before:
        restore.set(each)
    serial = next(channel for channel in restore.sheet.channels if isinstance(channel, (*WRITERS,)))
    if not restore.is_there:
        row_for(serial, WRITERS, "sends a program over")(restore)
    for each in restore.wanted.after:
        restore.set(each)


Writer = Callable[[Restore], None]
WRITERS: Mapping[type[Channel], Writer] = MappingProxyType({SerialLine: write_listed, AdaptiveLine: write_memory})
