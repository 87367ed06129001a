"""A reader of value change dumps (IEEE 1364), written by slewline, simulators or logic analysers.

A file is read in blocks, so that a long file needs little more memory than its edges.  Content that
cannot be read is an error that states the file, the line and the expected content; nothing is guessed.
"""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

from ...core.messages.calls import answering
from ...core.time.timebase import Time, picoseconds
from ...errors import BenchFileError, UsageError, WaveformError
from ...gate import BOM, opened
from .vcd_changes import Changes
from .vcd_header import FilePlace, Header, read_header
from .waveforms import Waveforms

BLOCK = 1 << 20  # bytes: this and the words of a block fit into a processor's cache
LONGEST, WORD = 1 << 28, 1 << 24  # bytes of declarations, of millions of variables; of a word, of a wide vector
PEEK = 4096  # bytes in which a binary file must have a zero
CUT_OFF = "it was cut off; torn=True, or --torn, reads what is before the cut"
FORMATS = {  # first bytes of files that are often taken for a VCD file
    b"\x1f\x8b": "compressed (gzip); unpack it with gunzip",
    b"BZh": "compressed (bzip2); unpack it with bunzip2",
    b"\xfd7zXZ": "compressed (xz); unpack it with unxz",
    b"PK": "a ZIP archive; read a session of PulseView (.sr) with read_waveforms, or convert it: "
    "sigrok-cli -i FILE.sr -O vcd -o FILE.vcd; for one of DSView (.dsl) or Logic 2 (.sal), export VCD or CSV there",
    b"\x00\x00\x00\x00\x00\x00\x00\x01\x49": "an FST file of GTKWave; convert it with: fst2vcd FILE.fst > FILE.vcd",
    b"\x13\x80": "an LXT2 file of GTKWave; convert it with: lxt2vcd FILE.lxt2 > FILE.vcd",
    b"<SALEAE>": "a binary export of Logic 2; export CSV there",
    b"VZ": "a VZT file of GTKWave; convert it with: vzt2vcd FILE.vzt > FILE.vcd",
    b"GHDLwave": "a GHW file of GHDL; write VCD there, with --vcd=FILE.vcd",
    b"\xff\xfe": "text in UTF-16; save it as plain ASCII",
    b"time_ps,chip,": "a table of steps (--steps, save_steps), without levels; write VCD: --vcd, or save_vcd",
    b"time_ps,net,": "a table of the edges of many pins (save_csv); write VCD: --vcd, or save_vcd",
}

_DEFINED = re.compile(rb"\$enddefinitions\s+\$end\s")


@answering("read_vcd()")
def read_vcd(path: str | Path, *, timescale: Time | None = None, torn: bool = False) -> Waveforms:
    """Return the waveforms in a VCD file.

    Times are rounded down to whole picoseconds if the file has finer times.

    Args:
        path: the file.
        timescale: the unit of time, for a file that does not declare one.
        torn: accept a file that was cut off: text after its last end of line is ignored.

    Raises:
        UsageError: the file cannot be opened, or `timescale` is missing or contradicts the file.
        TimeError: `timescale` is not a time.
        WaveformError: the content cannot be read; the message states line, reason and remedy.
    """
    unit = None if timescale is None else picoseconds(timescale)
    try:
        with opened(path) as file:
            return read_opened(path, file, unit, torn)
    except BenchFileError as error:
        raise UsageError(str(error)) from error
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror or error}") from error


def read_opened(path: str | Path, file: BinaryIO, unit: int | None, torn: bool) -> Waveforms:
    """Return the waveforms in an open VCD file, or in the VCD output of a program.

    Args:
        path: the path of the file, for messages.
        unit: the unit of time (ps), for a file that does not declare one.

    Raises:
        UsageError, WaveformError: as for `read_vcd`.
    """
    return Waveforms(path, *_read(str(path), file, unit, torn))


def _read(path: str, file: BinaryIO, unit: int | None, torn: bool) -> tuple[Header, Changes]:
    head = _head(path, file)
    header, at = read_header(FilePlace(path, head))
    if not header.variables:
        raise WaveformError(f"{path}: declares no variable ($var); the file may be cut off, or of another kind")
    if not (header.whole or torn):
        raise FilePlace(path, head).error(len(head.rstrip()) - 1, f"the file ends among its declarations: {CUT_OFF}")
    changes = Changes(path, header, _unit(path, header.unit, unit))
    lines, rest, more = head.count(b"\n", 0, at), head[at:], True
    while more:
        block = file.read(BLOCK)
        more, block = bool(block), rest + block
        if b"\r" in block and b"\n" not in block:
            block = block.replace(b"\r", b"\n")  # of an old Macintosh
        end = max(block.rfind(b"\n"), block.rfind(b" ") if more else -1) + 1  # the rest may continue
        taken = changes.feed(FilePlace(path, block[:end], lines)) if end else 0
        lines, rest = lines + block.count(b"\n", 0, taken), block[taken:]
        if len(rest) > WORD:
            raise FilePlace(path, rest[:BLOCK], lines).error(
                0, f"is longer than {WORD} bytes; check that it is a VCD file"
            )
    if rest.strip() and not torn:
        raise FilePlace(path, rest, lines).error(
            len(rest) - len(rest.lstrip()),
            f"the file ends within this: {CUT_OFF}",
        )
    return header, changes


def _head(path: str, file: BinaryIO) -> bytes:
    """Return the beginning of a file, up to at least the end of its declarations."""
    head = bytearray(file.read(BLOCK).removeprefix(BOM))
    if not head.strip():
        raise WaveformError(f"{path} is empty; nothing was written, or the program that writes it has not finished")
    for begin, what in FORMATS.items():
        if head.startswith(begin):
            raise WaveformError(f"{path}: not a VCD file: {what}")
    if b"\0" in head[:PEEK] and not head.lstrip().startswith(b"$"):
        raise WaveformError(f"{path}: a binary file, not a readable recording; export VCD or CSV instead")
    first = bytes(head[: head.find(b"\n")])
    if b"," in first and b"$" not in first:
        raise WaveformError(
            f"{path}: not a VCD file: its first line is that of a table (CSV); read it with read_waveforms, or give "
            "it to slewline compare as MEASURED"
        )
    seen = 0
    while _DEFINED.search(head, seen) is None and (more := file.read(BLOCK)):
        seen = max(len(head) - 100, 0)
        head += more
        if len(head) > LONGEST:
            raise WaveformError(f"{path}: no $enddefinitions in the first {LONGEST} bytes; check that it is a VCD file")
    return bytes(head)


def _unit(path: str, stated: Fraction | None, given: int | None) -> Fraction:
    if stated is None and given is None:
        raise UsageError(
            f"{path} has no $timescale; give the unit of its times: timescale='1 ns', or --timescale '1 ns'"
        )
    if stated is not None and given not in (None, stated):
        raise UsageError(f"{path}: its $timescale is {stated} ps, not the given {given} ps; leave out `timescale`")
    return stated if stated is not None else Fraction(given or 1)
