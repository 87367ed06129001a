"""decode: print the dialogue on two wires of a recording, and write it as a dialogue file."""

from __future__ import annotations

import click

from ...chips import sheet_of
from ...modules.decoding import decode_dialogue
from ...record.waveforms.read_waveforms import read_waveforms
from .. import FOUND

ARROWS = {"host": ">", "module": "<"}


def decode(
    file: str,
    part: str,
    host: str,
    module: str,
    baud: int | None,
    checksum: bool | None,
    address: int | None,
    timescale: int | None,
    threshold: str | None,
    torn: bool,
    dialogue: str | None,
) -> int:
    """Print a dialogue and its damaged characters; return 0 if no character is damaged, else 1."""
    waves = read_waveforms(file, timescale=timescale, torn=torn, threshold=threshold)
    found = decode_dialogue(waves, sheet_of(part), host, module, baud=baud, checksum=checksum, address=address or 0)
    if dialogue is not None:
        found.dialogue.write(dialogue)
    for entry in found.dialogue.entries:
        text = entry.data.decode("latin-1").encode("unicode_escape").decode("ascii")
        click.echo(f"{entry.at_us / 1000:12.3f} ms  {ARROWS[entry.speaker]} {text}")
    click.echo(f"slewline: {part} at {found.dialogue.header.baud} baud", err=True)
    for each in found.damaged:
        click.echo(f"slewline: {each}", err=True)
    return FOUND if found.damaged else 0
