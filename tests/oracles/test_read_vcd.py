"""slewline.read_vcd reads what sigrok-cli writes: the edges of all pins, to the sample."""

from __future__ import annotations

import numpy as np
import pytest

import slewline

from .programs import called

UNIT_PS = 1_000_000


@pytest.mark.system
@pytest.mark.parametrize("family", ["cy525", "gsc"])
def test_edges_of_a_run_come_back_from_a_session_of_sigrok(family, tmp_path, request):
    """Our file becomes samples, the samples a file of sigrok's.  A wire that floats is low there, and the
    instant at which the file ends is no sample any more."""
    bench = request.getfixturevalue(family)
    bench.save_vcd(tmp_path / "ours.vcd", timescale="1 us")
    called(["sigrok-cli", "-i", str(tmp_path / "ours.vcd"), "-o", str(tmp_path / "a.sr")])
    called(["sigrok-cli", "-i", str(tmp_path / "a.sr"), "-O", "vcd", "-o", str(tmp_path / "theirs.vcd")])
    theirs = slewline.read_vcd(tmp_path / "theirs.vcd")
    assert theirs.timescale_ps == UNIT_PS
    assert len(theirs) > 25
    for name in theirs:
        pin = name.replace("libsigrok", "x")
        samples = sampled(bench, pin, theirs.stop_ps // UNIT_PS)
        times, levels = theirs.edges(name)
        changes = np.flatnonzero(np.diff(samples)) + 1
        np.testing.assert_array_equal(times, changes * UNIT_PS)
        np.testing.assert_array_equal(levels, samples[changes])


def sampled(bench, pin, count):
    """The level of a pin at the end of every unit of time."""
    times, levels = bench.edges(pin)
    before = np.searchsorted(times, (np.arange(count) + 1) * UNIT_PS)
    return np.maximum(np.concatenate([[bench._signals.recorder.level(bench.pin(pin), 0)], levels])[before], 0)
