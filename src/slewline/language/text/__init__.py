"""Commands that consist of a letter and its arguments, as text or in binary form.

letter_dialects.py  `Letters`: arguments are decimal numbers and labels, a program is stored as opcodes;
                    `Verbatim`: also hexadecimal numbers, switches, queries and strings; a program is stored as text
forms.py            the common base of both dialects: signs, bytes on the wire
command_text.py     a decoded command; how commands are spelled
written_values.py   how numbers are written
decoder.py          characters in, commands out
entry.py            the end of program entry, for a program that is stored as text
text_reader.py      a line of a program, for assembler and linter
rules.py            the lint rules, except those about a running program, which are in live_rules.py
text_reference.py   the table of commands
"""

from __future__ import annotations

from .command_text import CommandText, Label, spell
from .decoder import Decoder
from .entry import Entry
from .forms import TextDialect
from .letter_dialects import Letters, Verbatim

__all__ = ["CommandText", "Decoder", "Entry", "Label", "Letters", "TextDialect", "Verbatim", "spell"]
