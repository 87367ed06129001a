"""Program files for a host: a script, or the bytes in a .hex file."""

from __future__ import annotations

from os import PathLike

from ...core.datasheet.table import Sheet
from ...errors import BenchFileError
from ...gate import read_file, read_text
from ...language.dialect import dialect_of
from ..files.hex_text import has_records, hex_lines, hex_text, is_named_hex
from .script import read_script
from .script_runner import Script


def program_text(path: str | PathLike[str], data: bytes | None = None) -> str:
    """Return the text of a program file; for a .hex file, pairs of hexadecimal digits.

    Args:
        data: the content of the file, if it has been read already.

    Raises:
        BenchFileError: the file cannot be read or is not text; or it is named .hex but is a memory image.
    """
    if not is_named_hex(path):
        return read_text(path, data)
    text = hex_text(read_file(path) if data is None else data, str(path))
    if has_records(text):
        remedy = "slewline dis lists it, and --memory, or file in a [[part]], loads it into a memory"
        raise BenchFileError(f"{path}: the image of a memory in Intel HEX, not a program for a host; {remedy}")
    return text


def program_script(text: str, where: str, sheet: Sheet) -> Script:
    """Return the script of a program file; that of a .hex file sends bytes line by line, or packets to a chipset.

    Args:
        where: the name of the file.
        sheet: the sheet of the chip that the host commands, or of the first such chip if there are several.

    Raises:
        BenchFileError: the file is named .hex but does not consist of pairs of hexadecimal digits.
    """
    if not is_named_hex(where):
        return read_script(text, where)
    lines = dialect_of(sheet).parted(hex_lines(text, where), sheet)
    return read_script("\n".join(line and f"@bytes {line}" for line in lines), where)
