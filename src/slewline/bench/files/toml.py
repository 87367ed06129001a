"""Untrusted TOML: content that would overload the reader is refused in advance; the message states its line.

The time and memory that Python's reader needs grow with the square of the number of parts in a dotted key; the
reader also accepts numbers of any length, which messages then cannot show.
"""

from __future__ import annotations

import re
import tomllib
from os import PathLike
from typing import Any

from ...errors import BenchFileError

PARTS, DIGITS = 32, 100  # a key with its table has three parts, and no time in picoseconds thirty digits

# A missing end is left to the reader: nothing here is scanned twice, however it is written.
_APART = re.compile(
    r'''
        """ (?: \\. | [^\\] )*? (?: """ | \Z )  |  \'{3} .*? (?: \'{3} | \Z )
        | " (?: \\. | [^"\\\n] )*+ "?           |  \' [^'\n]*+ \'?
        | \# [^\n]*+
    ''',
    re.DOTALL | re.VERBOSE,
)
_REFUSED = {
    re.compile(rf"(?<![\w.-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{PARTS}}}"): f"a key of more than {PARTS} parts; "
    "allowed table and key joined by a dot, such as options.rate",
    re.compile(rf"(?<![\w-])\d\w{{{DIGITS}}}"): f"a number of more than {DIGITS} digits; write a shorter one",
}

UNQUOTED = re.compile(r"\s*([\w.-]+)\s*=\s*([A-Za-z./][^\"'\[\]{}#=]*?)\s*(?:#.*)?")  # key = cy525


def read_toml(path: str | PathLike[str], text: str) -> dict[str, Any]:
    """Return the tables in the text of the file `path`.

    Raises:
        BenchFileError: the text is not TOML, or has keys or numbers longer than any file of slewline needs.
    """
    bare = _APART.sub(_masked, text)
    for pattern, message in _REFUSED.items():
        if found := pattern.search(bare):
            raise BenchFileError(f"{path}, line {text.count(chr(10), 0, found.start()) + 1}: {message}")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise BenchFileError(f"{path}: not readable TOML: its brackets are nested too deeply") from None
    except ValueError as error:
        raise BenchFileError(f"{path}: not TOML: {error}{unquoted(text, error)}") from None


def _masked(found: re.Match[str]) -> str:
    """Replace a string in a TOML text by underscores, or a comment by spaces; keep its line breaks.

    A masked string can then be read like a bare key, and line numbers do not change.
    """
    return re.sub(r"[^\n]", " " if found[0][0] == "#" else "_", found[0])


def unquoted(text: str, error: Exception) -> str:
    """Return a hint for a value that is not TOML and looks like text without quotes; "" for other values."""
    at = re.search(r"at line (\d+)", str(error))
    lines = text.splitlines()
    line = lines[int(at[1]) - 1] if at and int(at[1]) <= len(lines) else ""
    found = UNQUOTED.fullmatch(line)
    if found is None:
        return ""
    value = {"True": "true", "False": "false"}.get(found[2], f'"{found[2]}"')
    message = "write true and false in lower case" if found[2] in ("True", "False") else "put text in quotes"
    return f"; {message}: {found[1]} = {value}"
