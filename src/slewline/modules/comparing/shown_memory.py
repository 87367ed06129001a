"""The original content of a module's memory, as far as the listings in a dialogue show it.

Bytes that the host overwrites before they are listed are left out: the listing shows the new bytes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from ...core.memory.image import ERASED
from ..speech import QuerySpeech
from ..spoken import CR, Speech
from .exchanges import RecordedExchange


class ShownMemory:
    """A tracker of the memory pointer, and of the bytes written and listed, in a dialogue.

    `image` maps addresses to the listed bytes, except bytes that the host had already overwritten.
    """

    def __init__(self, speech: QuerySpeech) -> None:
        self.speech = speech
        (row,) = speech.sheet.acting("pointer")
        self.pointer_form = row.form
        self.enter = "" if speech.sheet.enter is None else speech.sheet.enter.form
        (leave,) = speech.sheet.leave
        self.leave = leave.form.encode("ascii")
        self.image: dict[int, int] = {}
        self.written: set[int] = set()
        self.pointer, self.entering, self.line = 0, False, b""

    def sent(self, data: bytes) -> int:
        """Process data sent to the module; return the number of memory lines that its last line requests."""
        asked = 0
        for byte in data:
            if self.entering:
                if not self.line and bytes([byte]) == self.leave:
                    self.entering = False
                    continue
                self.written.add(self.pointer)
                self.pointer += 1
                self.line = b"" if byte == CR[0] else self.line + bytes([byte])
            elif byte != CR[0]:
                self.line += bytes([byte])
            else:
                text, self.line = self.line.decode("latin-1").strip(), b""
                asked = self.speech.listed_lines(text)
                self.entering = text == self.enter
                if found := re.fullmatch(rf"{self.pointer_form} ?([0-9]+)", text):
                    self.pointer = int(found[1])
        return asked

    def came(self, lines: int, answer: bytes) -> None:
        """Read the given number of memory lines from an answer, in which they follow the line with the pointer."""
        answer = answer.replace(b"\r\n", CR)
        found = re.search(rb"%b=([0-9]{5})\r" % self.pointer_form.encode("ascii"), answer)
        if not found or not lines:
            return
        shown = b"".join(line + CR for line in answer[found.end() :].split(CR)[:lines])
        shown = answer[found.end() :][: len(shown)]
        for address, byte in enumerate(shown, start=int(found[1])):
            if byte == ERASED:
                break
            if address not in self.written:
                self.image.setdefault(address, byte)


def memory_of(exchanges: Iterable[RecordedExchange], speech: Speech) -> bytes:
    """Return a module's memory from address 0 on, as listed in a dialogue; empty if none of it is listed.

    Bytes between listed ones are returned as erased.
    """
    if not isinstance(speech, QuerySpeech):
        return b""
    shown = ShownMemory(speech)
    for exchange in exchanges:
        shown.came(shown.sent(exchange.sent), exchange.answer)
    size = max(shown.image, default=-1) + 1
    return bytes(shown.image.get(address, ERASED) for address in range(size))
