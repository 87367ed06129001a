"""sigrok-cli reads our VCD files: its decoders count the steps and read what was said on the line and on the bus.

A file of units of 1 us is read with a sample a unit; all that sigrok says is compared to the sample.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from slewline.cli.demo import TIMESCALE

from .conftest import SENT, TOLD
from .programs import find, sigrok

pytestmark = pytest.mark.system
UNIT_PS = 1_000_000
FORMAT = "baudrate=9600:data_bits=7:parity=odd:stop_bits=1.0:invert_rx=yes:invert_tx=yes:format=ascii"
LINE = f"uart:rx=rxd:tx=txd:{FORMAT}"
# A character: start bit, seven of data, parity, two stop bits.
BITS, BAUD = 11, 9600


BUS = ":".join(f"d{bit}={{0}}{bit}" for bit in range(8))  # the wires of a bus, to be named


def saved(bench, path, timescale="1 us"):
    bench.save_vcd(path, timescale=timescale)
    return path


@pytest.fixture(scope="module")
def feed(gsc, tmp_path_factory):
    return saved(gsc, tmp_path_factory.mktemp("sigrok") / "feed.vcd")


# ---------------------------------------------------------------------------------------------------------- steps
@pytest.mark.parametrize(
    ("family", "axis", "step", "direction"),
    [
        ("cy525", 1, "pulse", "direction"),
        ("gsc", 1, "clock", "dir"),
        ("mc1451a", 1, "pulse1", "dir1"),
        ("mc1451a", 2, "pulse2", "dir2"),
    ],
)
def test_every_step_is_counted_in_its_direction_and_to_the_microsecond(
    family, axis, step, direction, tmp_path, request
):
    """The decoder tells of a step when the next one comes: its last one is missing."""
    bench = request.getfixturevalue(family)
    path = saved(bench, tmp_path / "a.vcd")
    steps = bench["x"].axis(axis).steps()
    decoder = f"stepper_motor:step={step}:dir={direction}"

    said = sigrok(path, decoder, "position:speed")  # of every step two, when the next one comes
    times, levels = bench.edges(f"x.{step}")
    rising = (times[levels == 1] // UNIT_PS).tolist()
    expected = []
    for (start, stop), position in zip(pairwise(rising), steps.positions[:-1], strict=True):
        expected += [
            (start, stop, f"{1e12 / UNIT_PS / (stop - start):.0f} steps/s"),
            (start, stop, f"{position} steps"),
        ]
    assert said == expected


@pytest.mark.parametrize(("family", "step", "direction"), [("cy525", "pulse", "direction"), ("gsc", "clock", "dir")])
def test_velocity_of_an_axis_is_the_speed_that_sigrok_measures(family, step, direction, tmp_path, request):
    """As exactly as sigrok can: an interval is up to a sample too short or too long, and told in whole steps/s."""
    bench = request.getfixturevalue(family)
    x = bench["x"]
    said = sigrok(saved(bench, tmp_path / "a.vcd"), f"stepper_motor:step={step}:dir={direction}", "speed")
    within_a_move = np.diff(x.steps().directions) == 0
    said = [interval for interval, within in zip(said, within_a_move, strict=True) if within]
    middles = np.array([interval.start + interval.stop for interval in said]) * UNIT_PS // 2
    velocities = np.abs(x.velocity_at(middles))
    told = np.array([int(interval.text.split()[0]) for interval in said])
    intervals_ps = 1e12 / velocities
    assert np.all(told >= 1e12 / (intervals_ps + UNIT_PS) - 0.5)
    assert np.all(told <= 1e12 / (intervals_ps - UNIT_PS) + 0.5)
    assert len(set(told)) > 30


@pytest.mark.parametrize(
    ("options", "downsample"),
    [({"timescale": TIMESCALE, "values": True}, 1), ({"timescale": "1 ns"}, 1000)],
    ids=["as it is", "1 ns"],
)
def test_waveform_of_the_demo_is_read_in_samples_of_a_microsecond(options, downsample, demo, tmp_path):
    """What an axis does and what was commanded stands in the file too: sigrok warns of texts, and reads the wires."""
    demo.save_vcd(tmp_path / "weld.vcd", **options)
    decoder = "stepper_motor:step=pulse:dir=direction"
    warned = r"sr: input/vcd: Skipping unknown token '.*'\." if "values" in options else ""
    said = sigrok(tmp_path / "weld.vcd", decoder, "position", downsample, warned)
    steps = demo["x"].steps()
    assert len(said) == len(steps) - 1 == 16_799
    assert [told.text for told in said] == [f"{position} steps" for position in np.cumsum(steps.directions)[:-1]]
    times, levels = demo.edges("x.pulse")
    assert [told.start for told in said] == (times[levels == 1] // UNIT_PS).tolist()[:-1]


def test_counts_of_an_encoder_are_the_positions_of_its_shaft(encoder, tmp_path):
    """The shaft has as many counts as the motor has steps.  The decoder tells of a count when the next one comes."""
    said = sigrok(saved(encoder, tmp_path / "a.vcd"), "graycode:d0=quada1:d1=quadb1", "count")
    positions = encoder["x"].steps().positions
    assert max(positions) > 250 > min(positions[-10:])
    assert [int(told.text) for told in said] == [0, *positions[:-1]]


# ----------------------------------------------------------------------------------------------------------- line
def test_serial_lines_show_the_text_of_the_host_and_the_module(feed):
    heard = "".join(said.text for said in sigrok(feed, LINE, "rx-data")).replace("[0D]", "\r")
    assert heard == "".join(f"{line}\r" for line in TOLD)
    assert {"Po", "S10"} <= set(heard.split("\r"))
    answers = "".join(said.text for said in sigrok(feed, LINE, "tx-data")).replace("[0D]", "\r")
    assert answers == "Y\r" * 7 + "V+210\r"


def test_every_parity_and_stop_bit_is_right(feed):
    """Debian 12's decoder tells of a stop bit among the parity bits."""
    for wire, count in (("rx", sum(len(line) + 1 for line in TOLD)), ("tx", 7 * len("Y\r") + len("V+210\r"))):
        bits = [said.text for said in sigrok(feed, LINE, f"{wire}-parity-ok:{wire}-stop")]
        assert bits == ["Parity bit", "Stop bit"] * count
        assert sigrok(feed, LINE, f"{wire}-parity-err:{wire}-warnings") == []


def test_a_format_that_is_not_the_module_s_is_refused(feed):
    """What the tests above rest on: sigrok does look at the parity and at the polarity of the line."""
    count = sum(len(line) + 1 for line in TOLD)
    assert len(sigrok(feed, LINE.replace("odd", "even"), "rx-parity-err")) == count
    assert sigrok(feed, LINE.replace("invert_rx=yes", "invert_rx=no"), "rx-warnings")


def test_characters_follow_each_other_as_fast_as_the_line_allows(feed, gsc):
    """A start bit begins with its edge to the sample, and eleven bits later the next one of the line."""
    times, _ = gsc.edges("x.rxd")
    starts = [said.start for said in sigrok(feed, LINE, "rx-start")]
    assert set(starts) <= set((times // UNIT_PS).tolist())
    first = 0
    for line in TOLD:
        begins = starts[first : first + len(line) + 1]
        edge = times[times // UNIT_PS == begins[0]][0]
        assert begins == [int(edge + n * BITS * 10**12 // BAUD) // UNIT_PS for n in range(len(begins))]
        first += len(begins)


# ------------------------------------------------------------------------------------------------------------ bus
def test_bus_of_a_cy525_carries_the_bytes_that_the_host_sent(cy525, tmp_path):
    """The chip reads a byte until INSTROBE rises.  The decoder tells of a byte when the next one comes."""
    said = sigrok(saved(cy525, tmp_path / "a.vcd"), f"parallel:clk=instrobe:{BUS.format('db')}", "items")
    times, levels = cy525.edges("x.instrobe")
    read = (times[levels == 1] // UNIT_PS).tolist()
    assert [(byte.start, bytes.fromhex(byte.text)) for byte in said] == [
        (at, bytes([byte])) for at, byte in zip(read[:-1], SENT.encode()[:-1], strict=True)
    ]


def test_bus_of_an_mc1451a_carries_the_packets_that_the_host_wrote(mc1451a, tmp_path):
    """Codes of the commands, words with the high byte first; a strobe is 80 ns long."""
    mc1451a.save_vcd(tmp_path / "a.vcd", stop="8 ms", timescale="10 ns")
    said = sigrok(tmp_path / "a.vcd", f"parallel:clk=hostwrite:{BUS.format('hostdata')}", "items")
    first = "01  10 0000 0258  11 0004 0000  12 0000 1000"
    second = "02  10 ffff fed4  11 0002 0000  12 0000 0800"
    assert bytes.fromhex("".join(byte.text for byte in said)) == bytes.fromhex(f"{first} {second} 5b 00 03")[:-1]


# ------------------------------------------------------------------------------------------------------- programs
def test_program_that_is_missing_skips_the_test_and_fails_it_in_ci(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match="apt install sigrok-cli"):
        find("sigrok-cli")
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match="must not be skipped in CI"):
        find("sigrok-cli")
