"""A reader of recordings in any supported format: VCD, a table (CSV), or a sigrok session (.sr), via sigrok-cli."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import BinaryIO, cast

from ... import lifeline
from ...core.datasheet.units import measured, other_kind
from ...core.messages.calls import answering
from ...core.time.timebase import Time, picoseconds
from ...errors import BenchFileError, UsageError, WaveformError
from ...gate import BOM, MAX_LINE, opened
from .read_csv import read_csv
from .read_vcd import FORMATS, read_opened, read_vcd
from .waveforms import Waveforms

PEEK = 4096  # bytes that show the format of a file
TOOL = "sigrok-cli"
LONGEST_S = 600  # longest time of a conversion
SHOWN = 20  # characters of a name, and names, in a message
_CHANNEL = re.compile(r"(probe|analog)\d+=(.*)")


@answering("read_waveforms()")
def read_waveforms(
    path: str | Path, *, timescale: Time | None = None, torn: bool = False, threshold: str | float | None = None
) -> Waveforms:
    """Return the waveforms in a file from a logic analyser, an oscilloscope or a simulator: VCD, CSV or .sr.

    The format is recognised by the content.  A PulseView or sigrok-cli session (.sr) is converted by
    sigrok-cli, which must be installed.  A table (CSV) has a column for each signal; its first column
    contains the times, unless the file states a sample rate.  If a table has times before the trigger, time
    0 is the start of the recording.

    Args:
        path: the file.
        timescale: the unit of time, for a file that does not declare one; for a table without times, the
            time between two rows.
        torn: accept a file that was cut off: text after its last line end is ignored.
        threshold: for voltages, the value at and above which a level is 1, such as "1.4 V"; by default, for
            each signal, the midpoint between its two levels, disregarding spikes.

    Raises:
        UsageError: the file cannot be opened, is a session but sigrok-cli is not installed, or is a
            table without times whose row interval is not known; or `threshold` is not a voltage.
        TimeError: `timescale` is not a time.
        WaveformError: the content cannot be read; the message states line, reason and remedy.
    """
    volts = None if threshold is None else volts_of(threshold)
    try:
        with opened(path) as file:
            beginning = file.read(PEEK)
            if beginning.startswith(b"PK"):
                return _session(path, torn)
            if _is_table(beginning):
                file.seek(0)
                return read_csv(path, file, None if timescale is None else picoseconds(timescale), torn, volts)
    except BenchFileError as error:
        raise UsageError(str(error)) from error
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror or error}") from error
    return read_vcd(path, timescale=timescale, torn=torn)


def volts_of(threshold: str | float) -> float:
    """Return a threshold such as 1.4, "1.4 V" or "700 mV" as a number of volts.

    Raises:
        UsageError: `threshold` is not a voltage.
    """
    given = threshold.replace("v", "V") if isinstance(threshold, str) else threshold
    try:
        volts = measured(given, "V")
    except ValueError:
        volts = float("inf")
    if not abs(volts) < 1e6:
        kind = other_kind(threshold, "V")
        raise UsageError(f"threshold {threshold!r}: {kind}expected a voltage, such as '1.4 V' or '700 mV'")
    return volts


def _is_table(beginning: bytes) -> bool:
    """Return whether a file with the given beginning is a table; a VCD file begins with a declaration."""
    text = beginning.removeprefix(BOM).lstrip()
    if text.startswith(b"META "):
        text = text.partition(b"\n")[2].lstrip()
    if text[:1] in (b"$", b"") or text.startswith(b"#0") or any(beginning.startswith(mark) for mark in FORMATS):
        return False
    lines = text.replace(b"\r", b"\n").split(b"\n")[:20]
    return b"\0" not in text and any(mark in line for line in lines for mark in (b",", b";", b"\t"))


class WireChanges:
    """The VCD output of sigrok-cli, without the text lines that sigrok-cli adds for voltages: "A0: 3.30 V DC"."""

    def __init__(self, file: BinaryIO, voltages: list[str]) -> None:
        self.file, self.others = file, tuple(f"{name}: ".encode() for name in voltages)

    def read(self, size: int) -> bytes:
        """Return the next `size` bytes, or slightly more; fewer if the output ends before that, b"" at its end."""
        if not self.others:
            return self.file.read(size)
        lines, length = [], 0
        while length < size and (line := self.file.readline(MAX_LINE)):
            if not line.startswith(self.others):
                lines.append(line)
                length += len(line)
        return b"".join(lines)


def _channels(path: str | Path) -> tuple[list[str], list[str]]:
    """Return the names of a session's wires, and those of its voltages; empty lists if the session lists none.

    Raises:
        WaveformError: the file is a ZIP archive, but not a session.
    """
    import zipfile

    try:
        with zipfile.ZipFile(path) as archive:
            there, header = "metadata" in archive.namelist(), b""
            if there:
                with archive.open("metadata") as file:
                    header = file.read(PEEK * 16)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, ValueError, EOFError):
        return [], []  # sigrok-cli reports the error
    if not there:
        raise WaveformError(
            f"{path}: a ZIP archive, but not a session of sigrok; if it is a spreadsheet, save it as CSV"
        )
    lines = header.decode("utf-8", "replace").splitlines()
    named = [match.groups() for line in lines if (match := _CHANNEL.fullmatch(line.strip()))]
    return [name for kind, name in named if kind == "probe"], [name for kind, name in named if kind == "analog"]


def _session(path: str | Path, torn: bool) -> Waveforms:
    """Return the waveforms in a session, converted by sigrok-cli."""
    own = {".dsl": "export VCD or CSV in DSView", ".sal": "export CSV in Logic 2"}
    if Path(path).suffix.lower() in own:
        raise WaveformError(f"{path}: a session, but not a sigrok session; {own[Path(path).suffix.lower()]}")
    tool = shutil.which(TOOL)
    if tool is None:
        raise UsageError(
            f"{path}: a session of sigrok (.sr) needs {TOOL}, which is not installed; install {TOOL}, or "
            "export VCD in PulseView"
        )
    import threading

    wires, voltages = _channels(path)
    if voltages and not wires:
        shown = ", ".join(name[:SHOWN] for name in voltages[:SHOWN])
        raise WaveformError(f"{path}: a session with only voltages ({shown}), no logic levels; export CSV in PulseView")
    with tempfile.TemporaryFile() as errors:
        process = lifeline.start([tool, "-i", os.path.abspath(path), "-O", "vcd"], os.environ, errors)
        limit = threading.Timer(LONGEST_S, process.kill)
        limit.daemon = True
        limit.start()
        try:
            changes = WireChanges(cast(BinaryIO, process.stdout), voltages)
            found, failed = read_opened(path, cast(BinaryIO, changes), None, torn), None
        except WaveformError as error:
            found, failed = None, error
        finally:
            limit.cancel()
            process.kill()
            process.communicate()
        errors.seek(0)
        message = " ".join(errors.read(300).decode("utf-8", "replace").split())
    if found is None:
        raise WaveformError(f"{path}: {TOOL} cannot convert it: {message or failed}") from failed
    return found
