"""The value of --motor: a name from the list, data sheet figures as text, a TOML table, or a TOML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...bench.files.toml import read_toml
from ...errors import BenchFileError
from ...gate import read_text
from ...parts.motors.motors import read_motor

OPTION = "--motor"


def motor_value(text: str) -> Any:
    """Return the value of --motor in a form that `read_motor` accepts: text unchanged, or a checked table.

    Args:
        text: "QSH4218-51-10-049"; "current 2 A, resistance 1.4 ohm ..."; a table as in a bench file,
            '{ like = "QSH4218-51-10-049", inertia = "80 g cm2" }'; or the name of a file with the extension .toml.

    Raises:
        BenchFileError: the file cannot be read, is not TOML, or is a bench file.
        UnknownName, UsageError: the table is not a motor; the message names the file, or --motor.
    """
    if text.lstrip().startswith("{"):
        return _checked(read_toml(OPTION, f"motor = {text}")["motor"], OPTION)
    if not text.lower().endswith(".toml"):
        return text
    found = read_toml(text, read_text(text))
    if {"chip", "part"} & found.keys():
        raise BenchFileError(
            f"{text} is a bench file; allowed: the figures of one motor, one per line, such as "
            'current = "2 A" and resistance = "1.4 ohm"'
        )
    table = found["motor"] if found.keys() == {"motor"} else found
    if isinstance(table, dict) and "like" not in table:
        table = {"name": Path(text).stem} | table
    return _checked(table, text)


def _checked(value: Any, place: str) -> Any:
    read_motor(value, place)
    return value
