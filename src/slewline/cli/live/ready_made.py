"""slewline firmware: write the firmware of a board to a file, ready made, and say how it gets onto the board."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import click

from ...core.messages.near import hint
from ...errors import UsageError

HERE = Path(__file__).resolve().parents[2]


class Firmware(NamedTuple):
    """A firmware: the board it is for, its file, what it makes of the board, and how it gets there."""

    board: str
    file: str
    says: str
    how: tuple[str, ...]


FIRMWARE = {
    "gs-c200s": Firmware(
        "pico",
        "slewline-gs-c200s.uf2",
        "a Raspberry Pi Pico that takes the place of a GS-C200S",
        (
            "Hold BOOTSEL while you connect the Pico to a USB port: it appears as a drive, RPI-RP2.",
            "Copy the file to that drive.  The Pico restarts; a program that M has stored remains.",
        ),
    ),
    "uno": Firmware(
        "uno",
        "slewline-uno.hex",
        "an Arduino Uno that steps for slewline drive",
        ("Connect the Uno, and send the file:", "avrdude -p m328p -c arduino -P PORT -b 115200 -D -U flash:w:FILE:i"),
    ),
}


def places() -> list[Path]:
    """Return the folders where firmware may be: the package, the checkout that it is in, the current directory."""
    checkout = HERE.parents[1] / "build" / "firmware"
    return [HERE / "firmware", checkout, Path()]


def firmware(name: str | None, board: str | None, output: str | None, source: str | None) -> int:
    """Write the firmware of a name, or list all; returns the exit status.

    Raises:
        UsageError: no such firmware, or another board than it is for, or its file is in none of the places.
    """
    if name is None:
        for each, about in FIRMWARE.items():
            click.echo(f"{each:<10} --board {about.board:<6} {about.file:<24} {about.says}")
        return 0
    if name not in FIRMWARE:
        raise UsageError(f"firmware {name!r}: known are {', '.join(FIRMWARE)}{hint(name, FIRMWARE)}")
    about = FIRMWARE[name]
    if board not in (None, about.board):
        raise UsageError(f"--board {board}: the firmware {name} is for the board {about.board} alone")
    searched = [Path(source)] if source else places()
    found = next((place / about.file for place in searched if (place / about.file).is_file()), None)
    if found is None:
        raise UsageError(
            f"{about.file} is not here.  In a checkout make boards builds it; name the folder of a file that was built "
            "elsewhere with --from"
        )
    data, target = found.read_bytes(), Path(output or about.file)
    if target.suffix != found.suffix:
        raise UsageError(f"--output {target}: the file needs the ending {found.suffix}")
    target.write_bytes(data)
    click.echo(f"{target}: {len(data):,} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}")
    for line in about.how:
        click.echo(line.replace("FILE", str(target)))
    return 0
