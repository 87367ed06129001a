"""Recordings that sigrok-cli itself has written, in all of its forms, against the wave whose samples it was given."""

from __future__ import annotations

import re
import shutil
import zipfile

import numpy as np
import pytest

import slewline
from slewline.errors import UsageError, WaveformError
from tests.captures import Sampled, model, sigrok_converted, sigrok_session, wave
from tests.oracles.programs import find

pytestmark = pytest.mark.system
MHZ = 1_000_000
FORMS = {
    "vcd": "vcd",
    "samples": "csv",
    "times": "csv:time=true",
    "changes": "csv:time=true:dedup=true",
    "names": "csv:label=channel:time=true:dedup=true",
}


@pytest.fixture(scope="module")
def program() -> str:
    return find("sigrok-cli")


def agree(ours: slewline.Waveforms, theirs: slewline.Waveforms, mhz: int) -> None:
    assert str(theirs.sampling) == f"the sampling at {mhz} MHz"
    shift: str | int = "first"
    for name, other in zip(("STEP", "DIR"), theirs.names, strict=True):
        tolerance = ours.sampling_ps + theirs.sampling_ps
        found = slewline.compare_edges(ours.edges(name), theirs.edges(other), shift=shift, tolerance=tolerance)
        assert found.agrees and len(found.pairs) in (2, 380), found
        assert abs(found.drift_ppm) < 20 or len(found.pairs) == 2
        shift = found.shift_ps


ROWS = [(1, "vcd"), (12, "vcd"), (24, "vcd"), (48, "vcd"), *((12, form) for form in FORMS if form != "vcd"),
        (24, "changes"), (3, "times")]  # fmt: skip


@pytest.mark.parametrize(("mhz", "form"), ROWS)
def test_files_written_by_sigrok_agree(program, tmp_path, mhz, form):
    """Its column of times counts whole nanoseconds a sample, and so is 0.4 % slow at 12 MHz: samples are counted."""
    ours = slewline.read_vcd(model(wave(), tmp_path / "model.vcd"))
    session = sigrok_session(Sampled(wave(), mhz * MHZ), program, tmp_path / "a.sr")
    path = tmp_path / "a.txt"
    path.write_bytes(sigrok_converted(session, program, FORMS[form]))
    agree(ours, slewline.read_waveforms(path), mhz)


@pytest.mark.parametrize("mhz", [1, 12, 24])
def test_a_session_is_converted(program, tmp_path, mhz):
    ours = slewline.read_vcd(model(wave(), tmp_path / "model.vcd"))
    agree(ours, slewline.read_waveforms(sigrok_session(Sampled(wave(), mhz * MHZ), program, tmp_path / "a.sr")), mhz)


def with_voltages(session, path, *, wires: bool):
    """A session that an oscilloscope has written, too: a channel CH1 of volts, a block for each of the wires."""
    with zipfile.ZipFile(session) as old, zipfile.ZipFile(path, "w") as new:
        said = old.read("metadata").decode().replace("unitsize=1", "total analog=1\nanalog3=CH1\nunitsize=1")
        blocks = {name: old.read(name) for name in old.namelist() if name.startswith("logic")}
        if not wires:
            said = re.sub(r"(probe\d+|capturefile|unitsize)=.*\n?", "", said).replace(
                "total probes=2", "total probes=0"
            )
        new.writestr("version", old.read("version"))
        new.writestr("metadata", said)
        for name, data in blocks.items():
            if wires:
                new.writestr(name, data)
            volts = np.linspace(0, 3.3, len(data), dtype="<f4")
            new.writestr(name.replace("logic-1", "analog-1-3"), volts.tobytes())
    return path


def test_a_session_with_voltages_next_to_the_wires(program, tmp_path):
    session = sigrok_session(Sampled(wave(), MHZ), program, tmp_path / "a.sr")
    ours = slewline.read_vcd(model(wave(), tmp_path / "model.vcd"))
    mixed = with_voltages(session, tmp_path / "mixed.sr", wires=True)
    assert b"CH1: " in sigrok_converted(mixed, program, "vcd")
    found = slewline.read_waveforms(mixed)
    assert found.names == slewline.read_waveforms(session).names
    agree(ours, found, 1)
    with pytest.raises(
        WaveformError, match=r"alone\.sr: a session with only voltages \(CH1\), no logic levels; export"
    ):
        slewline.read_waveforms(with_voltages(session, tmp_path / "alone.sr", wires=False))


def test_a_session_that_is_damaged(program, tmp_path):
    session = sigrok_session(Sampled(wave(), MHZ), program, tmp_path / "a.sr")
    session.write_bytes(session.read_bytes()[:-200])
    with pytest.raises(WaveformError, match=r"a\.sr: sigrok-cli cannot convert it: "):
        slewline.read_waveforms(session)


def test_a_session_without_the_program(tmp_path, monkeypatch):
    (tmp_path / "a.sr").write_bytes(b"PK\x03\x04")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(UsageError, match="needs sigrok-cli, which is not installed; install sigrok-cli, or export"):
        slewline.read_waveforms(tmp_path / "a.sr")
