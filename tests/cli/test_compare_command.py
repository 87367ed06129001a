"""slewline compare: a measured file against the model's, as text and as data, and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

MODEL = """\
$timescale 1 us $end
$scope module x $end
$var wire 1 ! pulse $end
$var wire 1 " slew $end
$var real 64 # velocity $end
$upscope $end
$enddefinitions $end
#0
1!
1"
r0 #
#10
0!
#12
1!
#20
0!
0"
#22
1!
#30
"""
BOARD = """\
$timescale 1 ns $end
$scope module logic $end
$var wire 1 a D0 $end
$var wire 1 b D1 $end
$upscope $end
$enddefinitions $end
#5000 1a 1b
#15000 0a
#17000 1a
#25400 0a 0b
#27000 1a
#40000
"""


@pytest.fixture(autouse=True)
def files(folder: Path) -> None:
    (folder / "model.vcd").write_text(MODEL)
    (folder / "board.vcd").write_text(BOARD)


def test_signals_that_agree(call: Any) -> None:
    called = call("compare", "model.vcd", "board.vcd", "--map", "x.pulse=D0, slew = D1")
    assert (called.status, called.err) == (0, "")
    assert called.out.splitlines() == [
        "x.pulse: 4 edges in the model, 4 measured, shifted by -5 µs: agree within 1.001 µs",
        "  4 pairs: at most 400 ns apart, 100 ns on average",
        "slew: 1 edges in the model, 1 measured, shifted by -5 µs: agree within 1.001 µs",
        "  1 pair: at most 400 ns apart, 400 ns on average",
    ]


def test_signals_that_differ(call: Any) -> None:
    called = call(
        "compare", "model.vcd", "board.vcd", "--map", "x.pulse=D0", "--map", "slew=D1", "--tolerance", "100 ns"
    )
    assert called.status == 1 and called.out.splitlines()[1] == "  edge 2 (falls) at 20 µs is 400 ns late"
    assert called.out.count("400 ns late") == 2
    data = call("compare", "model.vcd", "board.vcd", "--map", "slew=D0", "--shift", "-5.4 us", "--json").json
    assert data == [
        {
            "signal": "slew", "agrees": False, "model_edges": 1, "measured_edges": 4, "pairs": 1,
            "shift_ps": -5_400_000,
            "tolerance_ps": 1_001_000, "greatest_ps": 0, "mean_ps": 0.0, "drift_ppm": 0.0, "within": "", "notes": [],
            "differences": [
                {"kind": "extra", "edge": 0, "time_ps": 9_600_000, "level": 0, "late_ps": 0},
                {"kind": "extra", "edge": 1, "time_ps": 11_600_000, "level": 1, "late_ps": 0},
                {"kind": "extra", "edge": 3, "time_ps": 21_600_000, "level": 1, "late_ps": 0},
            ],
        }
    ]  # fmt: skip


def test_the_first_signal_determines_the_shift(call: Any, folder: Path) -> None:
    (folder / "board.vcd").write_text(BOARD.replace("0b", "").replace("#27000 1a", "#27000 1a 0b"))
    called = call("compare", "model.vcd", "board.vcd", "--map", "pulse=D0,slew=D1", "--shift", "best")
    assert called.status == 1 and "edge 0 (falls) at 20 µs is 2 µs late" in called.out


def test_names_that_are_alike_need_no_map(call: Any, folder: Path) -> None:
    (folder / "board.vcd").write_text(BOARD.replace("D0", "pulse").replace("D1", "velocity"))
    called = call("compare", "model.vcd", "board.vcd")
    assert called.status == 0 and called.out.startswith("x.pulse: 4 edges") and len(called.out.splitlines()) == 2
    assert call("compare", "model.vcd", "model.vcd").out.count("agree") == 2


def test_files_that_need_an_option(call: Any, folder: Path) -> None:
    (folder / "board.vcd").write_text(BOARD.replace("$timescale 1 ns $end\n", "") + "#5")
    options = ("compare", "model.vcd", "board.vcd", "--map", "pulse=D0")
    assert "has no $timescale" in call(*options).err or "cut off" in call(*options).err
    assert "cut off" in call(*options, "--timescale", "1 ns").err
    assert call(*options, "--timescale", "1 ns", "--torn").status == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("model.vcd", "none.vcd"), "none.vcd cannot be read: No such file"),
        (("model.vcd", "board.vcd"), "the files have no signal name in common: "),
        (("model.vcd", "board.vcd", "--map", "pulse"), "--map pulse: name one signal from each file"),
        (("model.vcd", "board.vcd", "--map", "pulse=D7"), "board.vcd: no signal 'D7'; available: logic.D0, logic.D1"),
        (("model.vcd", "board.vcd", "--map", "velocity=D1"), "--map velocity=D1: expected signals with levels"),
        (("model.vcd", "board.vcd", "--map", "pulse=D0", "--shift", "soon"), "time 'soon': expected"),
    ],
)  # fmt: skip
def test_wrong_use(call: Any, arguments: tuple[str, ...], message: str) -> None:
    called = call("compare", *arguments)
    assert called.status == 2 and message in called.err and called.out == ""
