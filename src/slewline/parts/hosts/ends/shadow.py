"""Shadow registers: a part's registers (such as its mode), as a host infers them from the bytes sent.

A part that stores programs exactly as it receives them has no pin that shows its mode, so the host keeps
track of the mode.  The host is unaware of commands that reach the part over its other channel (bus
or serial line), and of the effects of a program stored in the part.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from ....core.datasheet.channel import AdaptiveLine, FlowBus
from ....core.wires.waiters import Event
from ....errors import UsageError
from ....language.dialect import spoken_as
from ....language.text import Entry, Verbatim

if TYPE_CHECKING:
    from ....core.datasheet.table import Sheet
    from ...base.part import Part
    from ..connection import Connection

TEXT = 0x80  # bit of the mode register: commands in ASCII
MODE, RESET = "MODE", "INITIALIZE"  # the commands that a host remembers


class Shadow:
    """A tracker of the bytes sent to a part; `mode` is the part's mode register, as inferred by the host."""

    def __init__(self, sheet: Sheet, on_reset: Callable[[], object] = lambda: None) -> None:
        self.sheet, self.dialect, self.on_reset = sheet, spoken_as(sheet, Verbatim), on_reset
        self.decoder = self.dialect.decoder(sheet)
        self.default = next(row.default for row in sheet.registers if row.name == "mode")
        self.reset()

    def reset(self) -> None:
        """Return to the initial state, because the part has been reset."""
        self.decoder.reset()
        self.entry: Entry | None = None
        self.mode = self.default
        self.started = ""  # the command that has started a program, which may run

    @property
    def ascii(self) -> bool:
        """True while the part, as far as the host knows, takes commands in ASCII, not in binary."""
        return bool(self.mode & TEXT)

    @property
    def at_letter(self) -> bool:
        """True if the next byte is the first byte of a command, outside program entry."""
        return self.entry is None and self.decoder.at_letter

    def take(self, data: bytes) -> None:
        """Track bytes that the host is sending to the part."""
        at = 0
        while at < len(data):
            kept = 0 if self.entry is not None else self.decoder.kept(data, at, self.ascii)
            if kept:
                self.decoder.keep(data[at : at + kept], self.ascii)
                at += kept
            else:
                self.feed(data[at])
                at += 1

    def feed(self, byte: int) -> None:
        """Track one byte that the host is sending to the part."""
        if self.entry is not None:
            if self.entry.ends(byte):
                self.entry = None
            return
        found = self.decoder.feed(byte, self.ascii)
        self.decoder.take_notes()
        if found is None:
            return
        if found.row.role == "enter":
            (leave,) = self.sheet.leave
            self.entry = Entry(leave, self.ascii)
        elif found.row.role == "run":
            self.started = found.text
        elif found.row.name == MODE and not found.switched:
            self.mode = found.values[0]
        elif found.row.name == RESET:
            self.reset()
            self.on_reset()

    # ------------------------------------------------------------------------------------------------------- queries
    def sent(self, command: str) -> bytes:
        """Return the bytes to send for a command in the current mode.

        Raises:
            UsageError: the text is not a command, or the command does not exist in binary mode.
        """
        return (self.dialect.sent if self.ascii else self.dialect.sent_binary)(self.sheet, command)

    def query(self, who: str, command: str) -> Query:
        """Return the `Query` for a command such as "? P"; error messages begin with `who`.

        Raises:
            UsageError: the command has no answer.
        """
        dialect = self.dialect
        letters, sign, listing = "".join(dialect.queries), re.escape(dialect.query), re.escape(dialect.listing)
        pattern = rf"{sign} ?(?:([{re.escape(letters)}])|({listing})[ ,]+([0-9]+))"
        match = re.fullmatch(pattern, command) if isinstance(command, str) else None
        if match is None:
            forms = ", ".join(f"{dialect.query} {letter}" for letter in (*letters, dialect.listing))
            raise UsageError(f"{who}: {command!r} has no answer; ask() is for {forms},n; use send() for other commands")
        return Query(self.dialect, match[1] or match[2], int(match[3] or 0), self.ascii)


class Query:
    """A query: whether it is in ASCII, and the pattern of its answer."""

    def __init__(self, dialect: Verbatim, letter: str, lines: int, ascii: bool) -> None:
        self.ascii = ascii
        if letter == dialect.listing:  # the pointer, then lines of the memory
            self.pattern = rb"Y=[0-9]+\r" + rb"[^\r]*\r" * lines if ascii else rb"Y=.." + rb"[^\r]*\r" * lines
        elif ascii:
            self.pattern = rb"%c=[0-9]{%d}\r" % (letter.encode(), dialect.queries[letter])
        else:
            self.pattern = rb"%c=.{%d}" % (letter.encode(), dialect.answer_bytes[dialect.queries[letter]])

    def answered(self, data: bytes | bytearray, since: int) -> str | bytes | None:
        """Return the answer found in `data` from index `since` on; None if there is none yet.

        In ASCII mode the answer is text, without its last carriage return; in binary mode it is bytes: letter,
        equals sign, and the value.
        """
        match = re.compile(self.pattern, re.DOTALL).search(data, since)
        if match is None:
            return None
        return match[0][:-1].decode("latin-1") if self.ascii else bytes(match[0])


class FlowControl:
    """The decision on whether a host obeys the flow line of its chip (FPL or CTS).

    Unless `heed` has set True or False, the host obeys the line while the chip's mode register, as far as
    the host knows it, enables the line.

    Attributes:
        gone: a shadow of the chip's registers, which tracks the bytes that the host sends.
        news: an event, notified of each of these bytes, and when the host starts or stops obeying the line.
        heeding: True or False, as set by `heed`; None: the host follows its own mode commands.
    """

    def __init__(self, chip: Connection, channel: FlowBus | AdaptiveLine, owner: str, gone: Shadow) -> None:
        self.owner, self.sheet, self.channel, self.gone = owner, chip.sheet, channel, gone
        self.heeding: bool | None = None
        self.news = Event(chip.bus.kernel, f"{owner}.(news)")

    @property
    def heeds(self) -> bool:
        """True while the host obeys the flow line."""
        if self.heeding is not None:
            return self.heeding
        mask, *values = self.channel.in_use
        return self.gone.mode & mask in values

    def heed(self, on: bool | None, part: Part) -> None:
        """Obey the flow line from now on (True), ignore it (False), or follow the host's mode commands (None).

        This call is recorded as an input of the part.

        Raises:
            UsageError: `on` is not True, False or None.
        """
        if on is not None and not isinstance(on, bool):
            raise UsageError(f"{self.owner}: heed({on!r}); allowed True, False, None")
        part.input("heed", on)
        self.heeding = on
        self.news.set()
        part.kernel.settle()

    def why_silent(self) -> str:
        """Return a possible reason for a missing answer, and the remedy; "" if the host can find no reason."""
        sheet, mode = self.sheet, self.gone.mode
        mask, here = self.channel.answers
        bus = sheet.channel(FlowBus)
        if bus is not None and not bus.live and self.gone.started:
            begun = f"{self.gone.started} has started a program"
            return (
                f"{begun}, and the {sheet.part} accepts no command while one runs: wait for its end, or end it with "
                "RESET"
            )
        if mode & mask == here:
            return ""
        sends = f"the mode register is {mode} and sends answers elsewhere"
        return f"as far as {self.owner} knows, {sends}: send O {mode & ~mask | here} to get them here"
