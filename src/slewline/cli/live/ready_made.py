"""slewline firmware: write prebuilt firmware for a board to a file, and print how to load it onto the board."""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit
from urllib.request import url2pathname

import click

from ...core.messages.near import hint
from ...errors import UsageError

HERE = Path(__file__).resolve().parents[2]


class Firmware(NamedTuple):
    """A firmware image: its board, its file, its purpose, and how to load it."""

    board: str
    file: str
    description: str
    how: tuple[str, ...]


FIRMWARE = {
    **{
        part: Firmware(
            "pico",
            f"slewline-{part}.uf2",
            f"a Raspberry Pi Pico that replaces a {part.upper()}",
            (
                "Hold BOOTSEL while you connect the Pico to a USB port: it appears as a drive, RPI-RP2.",
                "Copy the file to that drive.  The Pico restarts; a program stored by M is kept.",
                f"Then compare it with the model:  slewline firmware {part} --check PORT",
            ),
        )
        for part in ("gs-c200s", "gs-c200")
    },
    "uno": Firmware(
        "uno",
        "slewline-uno.hex",
        "an Arduino Uno, the board of slewline drive",
        ("Connect the Uno, and send the file:", "avrdude -p m328p -c arduino -P PORT -b 115200 -D -U flash:w:FILE:i"),
    ),
}


def next_to_the_wheel() -> list[Path]:
    """Return two folders: `firmware` next to the wheel file that was installed, and the folder of that file.

    Return [] if slewline was not installed from a wheel file.
    """
    try:
        origin = distribution("slewline").read_text("direct_url.json")
    except PackageNotFoundError:
        return []
    url = urlsplit(json.loads(origin or "{}").get("url", ""))
    if url.scheme != "file" or not url.path.endswith(".whl"):
        return []
    folder = Path(url2pathname(url.path)).parent
    return [folder / "firmware", folder]


def places() -> list[Path]:
    """Return the folders that may contain firmware: next to the wheel, in a checkout, in the current folder."""
    return [*next_to_the_wheel(), HERE.parents[1] / "build" / "firmware", Path("firmware"), Path()]


def firmware_of(name: str, board: str | None = None) -> Firmware:
    """Return the firmware image of this name.

    Raises:
        UsageError: there is no such firmware, or it is for another board.
    """
    if name not in FIRMWARE:
        raise UsageError(f"firmware {name!r}; allowed {', '.join(FIRMWARE)}{hint(name, FIRMWARE)}")
    about = FIRMWARE[name]
    if board not in (None, about.board):
        raise UsageError(f"--board {board}: the firmware {name} is only for the board {about.board}")
    return about


def write_firmware(name: str | None, board: str | None, output: str | None, source: str | None) -> int:
    """Write the firmware image of this name, or list all images if `name` is None; return the exit status.

    Raises:
        UsageError: there is no such firmware, it is for another board, its file is in none of the searched
            folders, or the extension of `output` is not that of the firmware's file.
    """
    if name is None:
        for each, about in FIRMWARE.items():
            click.echo(f"{each:<10} --board {about.board:<6} {about.file:<24} {about.description}")
        return 0
    about = firmware_of(name, board)
    searched = [Path(source)] if source else places()
    found = next((place / about.file for place in searched if (place / about.file).is_file()), None)
    if found is None:
        raise UsageError(
            f"{about.file} was not found.  A release includes it, next to the wheel; in a checkout, `make boards` "
            "builds it; give its folder with --from"
        )
    data, target = found.read_bytes(), Path(output or about.file)
    if target.suffix != found.suffix:
        raise UsageError(f"--output {target}: the file needs the extension {found.suffix}")
    target.write_bytes(data)
    click.echo(f"{target}: {len(data):,} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}")
    for line in about.how:
        click.echo(line.replace("FILE", str(target)))
    return 0
