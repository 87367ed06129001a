"""Dialogues with a part in virtual time, made without the code that replays them."""

from __future__ import annotations

import slewline
from slewline.bench.memories import put_memory
from slewline.chips import sheet_of
from slewline.core.datasheet.channel import AdaptiveLine
from slewline.language.lines import framed
from slewline.modules.dialogue import DialogueEntry, DialogueHeader, RecordedDialogue

PS_PER_US = 10**6
GSC = ["F", "V1", "Po", "S10", "T100", "R50", "+60", "D1", "-60", "Px", "Q", "E", *["F"] * 40, "V1", "S0", "Q", "V2"]
GSC200 = [{"Po": "P", "Px": "E"}.get(line, line) for line in GSC if line != "E"]  # E ends programming and runs
CY545 = [
    *("", "", "R 200", "F 10", "S 200", "? R", "? S", "A 0", "? P", "+", "N 4", "G", "? P", "? N", "? F", "? R"),
    *("Y 0", "E", "N 12", "R 7", "G", "0", "Q", "Y 0", "? M,3", "? Y", "? R", "N 9", "? N", "? N", "? S", "? F", "? Y"),
    *("? S", "? F", "? Y", "? P", "? N"),
]


def recorded(part, lines, *, pause_us=20_000, checksum=False, address=0, straps=None, **options):
    """Return the dialogue with a part: each line is sent `pause_us` after the answer to the line before."""
    sheet = sheet_of(part)
    bench = slewline.Bench()
    own = sheet.fastest | {"chs": int(checksum)} if part.startswith("gs-c") else {}
    chip = bench.add(part, straps=own | (straps or {}), **options)
    put_memory(bench, chip, None)
    over = sheet.through(AdaptiveLine).name if sheet.channel(AdaptiveLine) is not None else None
    host = bench.host(chip, over=over)
    if over is not None:
        host.heed(False)
    heard, said = [], []
    host.on_character.add(heard.append)
    bench.run("1 s")
    began = bench.kernel.now
    for line in lines:
        text = f"{address or ''}{line}"
        data = framed(text, checksum) if part.startswith("gs-c") else text.encode() + b"\r" * (line != "Q")
        at = bench.kernel.now
        host.write(data)
        bench.run(len(data) * host.uart.clock.ps(host.uart.word.ticks))
        said.append(DialogueEntry(us(at - began), us(at - began), "host", data))
        quiet = bench.kernel.now
        while bench.kernel.now < quiet + pause_us * PS_PER_US:
            bench.run("1 ms")
            if heard and heard[-1].end_ps > quiet:
                quiet = heard[-1].end_ps
        for begin, end, answer in lines_of(heard):
            said.append(DialogueEntry(us(begin - began), us(end - began), "module", answer))
        heard.clear()
    header = DialogueHeader(part, baud=int(host.baud), checksum=checksum, address=address, straps=straps or {})
    return RecordedDialogue(header, tuple(said))


def us(ps):
    """Return microseconds."""
    return ps // PS_PER_US


def lines_of(characters):
    """Yield lines: when their first and their last character was over, and the characters."""
    line = []
    for each in characters:
        line.append(each)
        if each.byte == 0x0D:
            yield line[0].end_ps, line[-1].end_ps, bytes(one.byte for one in line)
            line = []
    assert not line
