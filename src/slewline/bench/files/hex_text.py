"""Bytes as hexadecimal text, and files of such text; every reader of such files uses this module.

    52 7F 4E 2C 01    ; pairs of digits, a comment      bytes from a host, or a program without its address
    :0100100041AE                                        Intel HEX: the image of a memory

The name of a file determines its kind: a file whose name ends in .hex, .ihx or .ihex must be text in one of
these two forms.  Any other content is refused, with line and column, and never treated as the bytes of a program.
Lines end with LF, CR LF or CR; a byte order mark before the first line is skipped.
"""

from __future__ import annotations

import re

from ...core.memory.image import HEX, from_hex
from ...errors import BenchFileError
from ...gate import BOM

PAIRS = re.compile(r"(?:[0-9A-Fa-f]{2}[ \t]*)*")
LINE_ENDS = re.compile(r"\r\n|\r|\n")  # str.splitlines breaks at other characters as well


def is_named_hex(name: object) -> bool:
    """Return whether the name of a file has an extension for hexadecimal text."""
    return str(name).lower().endswith(HEX)


def hex_text(data: bytes, where: str) -> str:
    """Return the text of a file of hexadecimal bytes, with lines that end with LF.

    Args:
        data: the content of the file.
        where: the file, for messages.

    Raises:
        BenchFileError: the file is empty, or has a byte outside of comments that is not ASCII text; the message
            states line and column of such a byte.
    """
    lines = LINE_ENDS.split(data.removeprefix(BOM).decode("latin-1"))
    if not any(line.strip() for line in lines):
        raise BenchFileError(f"{where}: the file is empty; write pairs of hexadecimal digits, such as 43 00")
    for number, line in enumerate(lines, 1):
        for column, character in enumerate(line.split(";", 1)[0], 1):
            if character != "\t" and not " " <= character <= "~":
                found = f"{where}, line {number}, column {column}: byte {ord(character):02X}"
                remedy = "put raw bytes into a .bin file"
                raise BenchFileError(f"{found}; allowed: text with pairs of hexadecimal digits, or Intel HEX; {remedy}")
    return "\n".join(lines)


def has_records(text: str) -> bool:
    """Return whether a text is Intel HEX, valid or damaged: such a text begins with a colon."""
    return text.lstrip().startswith(":")


def hex_bytes(data: bytes, where: str) -> bytes:
    """Return the bytes in hexadecimal text: pairs of digits, or Intel HEX.

    Raises:
        BenchFileError: the file is empty, or contains anything other than these.
    """
    text = hex_text(data, where)
    return from_hex(text, where) if has_records(text) else bytes.fromhex(" ".join(hex_lines(text, where)))


def hex_lines(text: str, where: str) -> list[str]:
    """Return the lines of a text of hexadecimal digit pairs, without their comments.

    Raises:
        BenchFileError: a line contains anything but such pairs (the message states line and column), or no line
            contains a byte.
    """
    found = []
    for number, line in enumerate(text.split("\n"), 1):
        code = line.split(";", 1)[0].rstrip()
        body = code.lstrip()
        good = PAIRS.match(body)
        end = good.end() if good else 0
        if end < len(body):
            at = f"{where}, line {number}, column {len(code) - len(body) + end + 1}"
            raise BenchFileError(f"{at}: {body[:60]!r}: bytes are pairs of hexadecimal digits, such as 43 00")
        found.append(body)
    if not any(found):
        raise BenchFileError(f"{where} has no bytes; write pairs of hexadecimal digits, such as 43 00")
    return found
