"""The detection of the end of program entry, for a program whose characters are stored as received."""

from __future__ import annotations

from ...core.datasheet.table import Row
from .command_text import CR, OPEN_BUS


class Entry:
    """A detector of the letter that ends program entry; this letter also occurs within programs.

    In ASCII the letter counts only as the first character of a line, in binary only in place of an opcode;
    the detector finds the opcodes by following the byte counts of the commands.
    """

    def __init__(self, leave: Row, ascii: bool) -> None:
        self.leave, self.ascii = ord(leave.form), ascii
        self.at_letter, self.counted, self.left = True, False, 0

    def ends(self, byte: int) -> bool:
        """Process a byte; return True if it ends program entry, False if it is to be stored."""
        if self.at_letter and byte == self.leave:
            return True
        if self.ascii:
            self.at_letter = byte == CR
        elif self.at_letter:
            self.at_letter, self.counted = byte == OPEN_BUS, False
        elif not self.counted:
            self.counted, self.left = True, byte
            self.at_letter = not byte
        else:
            self.left -= 1
            self.at_letter = not self.left
        return False
