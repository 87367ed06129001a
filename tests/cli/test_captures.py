"""Recordings of a known wave, in the forms of many instruments, against the wave: the verdict is right in each."""

from __future__ import annotations

import pytest

import slewline
from slewline.cli import FOUND
from slewline.record.measuring.intervals import SignalEdges
from slewline.record.measuring.measure import pulse_widths
from slewline.record.measuring.overlay import differing
from tests import captures
from tests.captures import FORWARD, US, Sampled, sigrok_vcd, wave

MAP = "x.STEP=STEP,x.DIR=DIR"
MHZ = 1_000_000
PLAIN = wave()
OPTO = PLAIN.inverted("STEP", "DIR")

# name of the file, content, more options, exit status, what is printed
CASES: list[tuple[str, bytes, list[str], int, list[str]]] = [
    *(
        (f"sigrok_{mhz}.vcd", sigrok_vcd(Sampled(PLAIN, mhz * MHZ)), [], 0, [f"agree within the sampling at {mhz} MHz"])
        for mhz in (1, 2, 4, 8, 12, 16, 24, 48)
    ),
    *(
        (
            f"bare_{mhz}.vcd",
            sigrok_vcd(Sampled(PLAIN, mhz * MHZ), comment=False),
            [],
            0,
            [f"agree within the sampling at {mhz} MHz"],
        )
        for mhz in (12, 16, 24, 48)
    ),
    *(
        (
            f"inverted_{mhz}.vcd",
            sigrok_vcd(Sampled(OPTO, mhz * MHZ)),
            [],
            FOUND,
            ["agrees when inverted: --invert x.DIR,x.STEP"],
        )
        for mhz in (1, 12)
    ),
    ("inverted.vcd", sigrok_vcd(Sampled(OPTO, 24 * MHZ)), ["--invert", "all"], 0, ["the sampling at 24 MHz"]),
    (
        "dir_inverted.vcd",
        sigrok_vcd(Sampled(PLAIN.inverted("DIR"), 24 * MHZ)),
        [],
        FOUND,
        ["x.STEP: 380 edges in the model, 380 measured", "agrees when inverted: --invert x.DIR"],
    ),
    *(
        (
            f"swapped_{mhz}.vcd",
            sigrok_vcd(Sampled(PLAIN.swapped("STEP", "DIR"), mhz * MHZ)),
            [],
            FOUND,
            ["STEP and DIR are swapped: --map x.STEP=DIR,x.DIR=STEP"],
        )
        for mhz in (4, 24)
    ),
    (
        "both.vcd",
        sigrok_vcd(Sampled(OPTO.swapped("STEP", "DIR"), 12 * MHZ)),
        [],
        FOUND,
        ["STEP and DIR are swapped: --map x.STEP=DIR,x.DIR=STEP --invert x.DIR,x.STEP"],
    ),
    (
        "late.vcd",
        sigrok_vcd(Sampled(PLAIN.delayed("DIR", 7 * US), 24 * MHZ)),
        [],
        FOUND,
        ["x.STEP: 380 edges", "agree within", "agrees except for a constant delay of 7 µs"],
    ),
    *(
        (
            f"no_first_{mhz}.vcd",
            sigrok_vcd(Sampled(PLAIN, mhz * MHZ), first=False),
            [],
            0,
            [f"agree within the sampling at {mhz} MHz"],
        )
        for mhz in (4, 12)
    ),
    *(
        (
            f"jitter_{mhz}.vcd",
            sigrok_vcd(Sampled(PLAIN.jittered(2 * US, mhz), mhz * MHZ)),
            [],
            FOUND,
            ["no edge is missing or extra; with --tolerance"],
        )
        for mhz in (12, 24)
    ),
    (
        "cut.vcd",
        sigrok_vcd(Sampled(PLAIN, 12 * MHZ))[:4000],
        ["--torn"],
        FOUND,
        ["is missing"],
    ),
    ("cut_whole.vcd", sigrok_vcd(Sampled(PLAIN, 12 * MHZ))[:4000], [], 2, ["it was cut off"]),
    *(
        (
            f"saleae_{mhz}.csv",
            captures.saleae_csv(Sampled(PLAIN, mhz * MHZ), trigger),
            [],
            0,
            [f"agree within the sampling at {mhz} MHz"],
        )
        for mhz, trigger in ((24, 0), (16, 1_500 * US), (12, 1_000 * US))
    ),
    ("saleae_inv.csv", captures.saleae_csv(Sampled(OPTO, 24 * MHZ)), ["--invert", "STEP,x.DIR"], 0, ["agree"]),
    ("dsview.csv", captures.dsview_csv(Sampled(PLAIN, 24 * MHZ)), [], 0, ["agree within the sampling at 24 MHz"]),
    ("dsview.vcd", sigrok_vcd(Sampled(PLAIN, 12 * MHZ), bom=True), [], 0, ["agree within the sampling at 12 MHz"]),
    ("mac.vcd", sigrok_vcd(Sampled(PLAIN, 12 * MHZ), end="\r"), [], 0, ["agree within the sampling at 12 MHz"]),
    ("dos.vcd", sigrok_vcd(Sampled(PLAIN, 12 * MHZ), end="\r\n"), [], 0, ["agree within the sampling at 12 MHz"]),
    *(
        (f"{form}.csv", captures.scope_csv(Sampled(PLAIN, MHZ), form), [], 0, ["agree within the sampling at 1 MHz"])
        for form in ("rigol", "keysight", "pico", "siglent", "tektronix", "waveforms")
    ),
    (
        "threshold.csv",
        captures.scope_csv(Sampled(PLAIN, MHZ), "keysight", 5.0),
        ["--threshold", "2 V"],
        0,
        ["agree within the sampling at 1 MHz"],
    ),
]


def test_the_verdict_on_a_capture_is_right(call, subtests, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    captures.model(PLAIN, tmp_path / "model.vcd")
    assert len(CASES) >= 34
    for name, content, options, status, says in CASES:
        with subtests.test(name):
            (tmp_path / name).write_bytes(content)
            called = call("compare", "model.vcd", name, "--map", MAP, *options)
            printed = called.out + called.err
            assert called.status == status, printed
            assert all(each in printed for each in says), printed


def test_every_reader_agrees_on_first_levels_that_are_missing(call, tmp_path, monkeypatch):
    """Such a file reads as one that has them: edges, steps, traces, measurements, comparisons, overlays, checks."""
    monkeypatch.chdir(tmp_path)
    for name, first in (("with.vcd", True), ("without.vcd", False)):
        (tmp_path / name).write_bytes(sigrok_vcd(Sampled(PLAIN, 4 * MHZ), first=first))
    given, bare = (slewline.read_waveforms(tmp_path / name) for name in ("with.vcd", "without.vcd"))
    whole = given.steps("STEP", "DIR", edge="rising")
    assert bare.steps("STEP", "DIR", edge="rising").positions.tolist() == whole.positions.tolist()
    for name in ("STEP", "DIR"):
        assert bare.level_at(name, bare.start_ps) == given.level_at(name, given.start_ps)
        edges, others = given.edges(name), bare.edges(name)
        assert [column.tolist() for column in edges] == [column.tolist() for column in others]
        assert pulse_widths(*edges, 1).tolist() == pulse_widths(*others, 1).tolist()
        model, over = given.trace(name), bare.trace(name)
        assert not len(differing(model, over, 0, given.stop_ps)) and over.level == model.level
        rises = [SignalEdges.of_trace(trace, 0, given.stop_ps).edges("rises").tolist() for trace in (model, over)]
        assert rises[0] == rises[1] == edges[0][edges[1] == 1].tolist()
    assert call("compare", "with.vcd", "without.vcd").status == 0
    found = [slewline.check_capture(waves, {"x": ("STEP", "DIR")}, driver="DM542") for waves in (given, bare)]
    assert str(found[0]) == str(found[1]) and found[1].good


@pytest.mark.parametrize("form", ["vcd", "saleae", "dsview", "rigol"])
def test_steps_are_counted_in_every_form(form, tmp_path):
    seen = Sampled(PLAIN, MHZ)
    content = {
        "vcd": lambda: sigrok_vcd(seen, first=False),
        "saleae": lambda: captures.saleae_csv(seen),
        "dsview": lambda: captures.dsview_csv(seen),
        "rigol": lambda: captures.scope_csv(seen, "rigol"),
    }[form]()
    path = tmp_path / f"a.{'vcd' if form == 'vcd' else 'csv'}"
    path.write_bytes(content)
    steps = slewline.read_waveforms(path).steps("STEP", "DIR", edge="rising")
    assert (steps.directions > 0).sum() == FORWARD and steps.positions[-1] == FORWARD - captures.BACK


def test_check_capture(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.vcd").write_bytes(sigrok_vcd(Sampled(PLAIN, 24 * MHZ)))
    called = call("check-capture", "a.vcd", "--axis", "x=STEP,DIR", "--driver", "DM542", "--plot", "a.svg")
    assert called.status == 0 and "x  DIR before STEP" in called.out and (tmp_path / "a.svg").exists()
    late = Sampled(PLAIN.delayed("DIR", 18 * US), 24 * MHZ)
    (tmp_path / "late.csv").write_bytes(captures.saleae_csv(late))
    data = call("check-capture", "late.csv", "--axis", "x=STEP,DIR", "--driver", "DM542", "--json")
    assert data.status == FOUND and not data.json["good"]
    (wrong,) = [row for row in data.json["limits"] if row["violations_ps"]]
    assert wrong["says"] == "DIR before STEP" and wrong["shortest_ps"] < 2_100_000
    for option, says in ((["--axis", "x"], "--axis x: expected"), (["--axis", "x=STEP,"], "expected STEP and DIR")):
        assert says in call("check-capture", "a.vcd", *option).err


def test_compare_on_a_constant_signal(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    still = captures.Wave({**PLAIN.edges, "DIR": []}, PLAIN.first, PLAIN.end)
    captures.model(still, tmp_path / "model.vcd")
    (tmp_path / "a.vcd").write_bytes(sigrok_vcd(Sampled(still.inverted("DIR"), 12 * MHZ)))
    called = call("compare", "model.vcd", "a.vcd", "--map", MAP)
    assert called.status == 0 and "no edges; its level is 1, that of the model 0; it may be inverted" in called.out
    assert "no edges" not in call("compare", "model.vcd", "a.vcd", "--map", MAP, "--invert", "DIR").out
    says = call("compare", "model.vcd", "a.vcd", "--map", MAP, "--invert", "D7").err
    assert "--invert D7: not a wire that is compared; allowed x.STEP, x.DIR, all" in says
    data = call("compare", "model.vcd", "a.vcd", "--map", MAP, "--json").json
    assert data[0]["within"] == "the sampling at 12 MHz" and len(data[1]["notes"]) == 1
