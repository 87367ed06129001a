"""slewline ramp: what it prints, as text and as data, and what it refuses."""

from __future__ import annotations

import re
from typing import Any

import pytest

import slewline
from slewline.core.time.timebase import readable

CY, GSC, MC = (
    ("cy525", "F=3", "R=80", "S=100"),
    ("gs-c200", "S=10", "T=100", "R=50"),
    ("mc1451a", "SET_VEL=65536", "SET_ACC=1024"),
)


def test_a_ramp_is_described_in_five_lines(call: Any) -> None:
    ramp = slewline.ramp("cy525", F=3, R=80, S=100)
    first, mean, greatest = (round(each) for each in ramp.accelerations)
    assert call("ramp", *CY).out.splitlines() == [
        "cy525, 11 MHz: F 3, R 80, S 100, Z 1",
        "rates         300 to 5978 steps/s",
        f"ramp          {readable(ramp.time_ps)}, {ramp.steps} steps",
        f"acceleration  {mean} steps/s² on average, initially {first}, maximum {greatest}",
        f"full rate     reached in moves of {ramp.reached_from} steps or more",
    ]


@pytest.mark.parametrize(("arguments", "lines"), [
    (GSC, {"acceleration": "9900 steps/s²", "rates": "100 to 1000 steps/s", "ramp": "96.125149 ms, 50 steps"}),
    (MC, {"rates": "0 to 3052 steps/s", "ramp": "20.64384 ms, 31.5 steps", "acceleration": "145519 steps/s²"}),
    (
        ("cy525", "F=9", "R=9", "S=1"),
        {
            "ramp": "none: the rate is not above the first one (F 9, R 9)",
            "full rate": "reached in moves of 1 step or more",
        },
    ),
    (("cy525", "F=3", "R=127", "S=1", "Z=200"), {"full rate": "reached in no move"}),
])  # fmt: skip
def test_constant_values_are_one_number_and_missing_ones_are_reported(
    call: Any, arguments: tuple[str, ...], lines: dict[str, str]
) -> None:
    found = dict(
        re.split(r"\s{2,}", line, maxsplit=1) for line in call("ramp", *arguments).out.splitlines()[1:] if line
    )
    assert {name: found[name] for name in lines} == lines


def test_a_distance_adds_the_move_and_its_time(call: Any) -> None:
    ramp = slewline.ramp("cy525", F=3, R=80, S=100)
    *_, long = call("ramp", *CY, "--distance", "20000").out.splitlines()
    *_, short = call("ramp", *CY, "--distance", "500").out.splitlines()
    slew = 20_000 - 2 * ramp.steps
    assert (
        long == f"20000 steps   {readable(ramp.move(20_000).time_ps)}: up {ramp.steps}, slew {slew}, down {ramp.steps}"
    )
    assert short.startswith("500 steps     ") and ": up 250, down 250; reaches " in short


def test_the_table_has_a_line_for_every_rate(call: Any) -> None:
    ramp = slewline.ramp("cy525", F=3, R=80, S=100)
    lines = call("ramp", *CY, "--table").out.splitlines()[5:]
    assert lines[0].split() == ["time", "position", "rate", "steps/s", "steps"]
    assert [line.split()[-3:] for line in lines[1:]] == [
        [str(row.parameter), f"{row.rate:.0f}", str(row.steps)] for row in ramp.table()
    ]
    assert len({len(line) for line in lines}) == 1


def test_search_results_are_listed_best_first(call: Any) -> None:
    found = slewline.find_ramps("cy525", F=3, R=80, time="0.5 s", count=3)
    ran = call("ramp", "cy525", "F=3", "R=6000 steps/s", "--time", "0.5 s", "--best", "3")
    head, columns, *rows = ran.out.splitlines()
    assert (ran.status, head) == (0, "cy525, 11 MHz: F 3, R 80; 300 to 5978 steps/s")
    assert columns.split() == ["S", "Z", "steps", "steps/s²", "time"]
    assert [" ".join(row.split()) for row in rows] == [
        f"{each.values['S']} {each.values['Z']} {each.steps} {each.acceleration:.0f} {readable(each.time_ps)}"
        for each in found
    ]


def test_a_time_below_a_nanosecond_is_taken_with_its_unit(call: Any) -> None:
    ran = call("ramp", "cy525", "F=3", "R=20", "--time", "5 ps", "--json")
    assert (ran.status, ran.json["wanted"]) == (0, {"time_ps": 5})


@pytest.mark.parametrize(("option", "wanted"), [
    (("--accel", "20000 steps/s2"), {"acceleration": 20_000}),
    (("--steps", "300"), {"steps": 300}),
    (("--time", "40 ms"), {"time": "40 ms"}),
])  # fmt: skip
@pytest.mark.parametrize("part", ["cy525", "gs-c200s", "mc1251a-e"])
def test_each_part_looks_for_each_thing(call: Any, part: str, option: tuple[str, ...], wanted: dict[str, Any]) -> None:
    given = {"cy525": {"F": 3, "R": 80}, "gs-c200s": {"S": 10, "T": 300}, "mc1251a-e": {"SET_VEL": 265107}}[part]
    ran = call(
        "ramp", part, *(f"{name}={value}" for name, value in given.items()), *option, "--json", "--distance", "900"
    )
    found = slewline.find_ramps(part, **given, **wanted)
    free = {"cy525": ["S", "Z"], "gs-c200s": ["R"], "mc1251a-e": ["SET_ACC"]}
    assert (ran.json["free"], list(ran.json["wanted"].values())) == (
        free[part],
        [4e10 if "time" in wanted else next(iter(wanted.values()))],
    )
    assert [each["parameters"] for each in ran.json["found"]] == [dict(ramp.values) for ramp in found]
    assert [each["time_ps"] for each in ran.json["found"]] == [ramp.time_ps for ramp in found]
    assert [each["move"]["time_ps"] for each in ran.json["found"]] == [ramp.move(900).time_ps for ramp in found]


def test_a_ramp_as_data(call: Any) -> None:
    found = call("ramp", *GSC, "--distance", "80", "--table", "--json").json
    table, move = found.pop("table"), found.pop("move")
    assert found == {
        "chip": "gs-c200",
        "crystal_hz": None,
        "parameters": {"S": 10, "T": 100, "R": 50, "law": "constant acceleration"},
        "start_sps": 100,
        "top_sps": 1000,
        "time_ps": 96_125_149_279,
        "steps": 50,
        "acceleration_sps2": pytest.approx({"first": 9900, "mean": 9900, "greatest": 9900}),
        "reached_from": slewline.ramp("gs-c200", S=10, T=100, R=50).reached_from,
    }
    assert (len(table), table[0]) == (50, {"begin_ps": 0, "position": 0, "steps": 1, "rate": 100, "parameter": None})
    assert (move["steps"], move["reached"], sum(move["legs"].values())) == (80, False, 80)


@pytest.mark.parametrize(("arguments", "steps"), [
    ((*CY, "--distance", "99"), 99),
    (GSC, slewline.ramp("gs-c200", S=10, T=100, R=50).reached_from),
    (MC, slewline.ramp("mc1451a", SET_VEL=65536, SET_ACC=1024).reached_from),
])  # fmt: skip
def test_a_plot_shows_the_requested_move_or_the_shortest_that_reaches_its_rate(
    call: Any, folder: Any, arguments: tuple[str, ...], steps: int
) -> None:
    assert call("ramp", *arguments, "--plot", "x.svg").out.endswith("\nwrote x.svg\n")
    text = (folder / "x.svg").read_text()
    assert re.search(rf">{arguments[0]}[^<]*: {steps} steps<", text)
    assert ">Velocity, steps/s<" in text and ">Position, steps<" in text and ">top, " in text


WRONG = [
    (("cy999",), "no chip 'cy999'; available: cy525"),
    (("cy525", "R"), "'R': give a parameter and its value, such as R=100"),
    (("cy525", "R=1", "r=2"), "cy525: r is given twice; give one value"),
    ((*CY, "time=3", "--steps", "4"), "cy525: no parameter 'time'; available: F, R, S, Z"),
    ((*CY, "part=3"), "cy525: no parameter 'part'; available: F, R, S, Z"),
    (("cy525", "F=3", "R=200", "S=1"), "cy525: R '200'; allowed 0..127"),
    (("cy525", "F=3", "R=9"), "cy525: no value for S (acceleration"),
    ((*CY, "--time", "1 s", "--accel", "4 steps/s2"), "exactly one goal: time, acceleration or steps"),
    ((*CY, "Z=1", "--time", "1 s"), "every parameter is given; leave out S or Z"),
    ((*CY, "--distance", "70000"), "a move of 70000 steps; allowed 1..65535"),
    ((*GSC, "--distance", "0"), "a move of 0 steps; allowed 1..9999999"),
    ((*MC, "--distance", "2147483648"), "a move of 2147483648 steps; allowed 1..1073741823"),
    ((*CY, "--crystal", "40 MHz"), "CY525 takes 1 to 11 MHz"),
    ((*GSC, "--crystal", "4 MHz"), "the gs-c200 has no selectable crystal"),
    ((*CY, "--plot", "x.txt"), "x.txt: give a name that ends in .svg, .png or .pdf"),
    (
        ("cy525", "F=3", "R=127", "S=1", "Z=200", "--plot", "x.svg"),
        "no move reaches 9675 steps/s; give a move with --distance",
    ),
    ((*MC, "--distance", "5000001", "--plot", "x.svg"), "x.svg: 5000001 steps; allowed up to 5000000"),
    (("mc1451a", "profile=s-curve", "SET_VEL=9", "--time", "1 s"), "SET_MAX_ACC and SET_JERK cannot both be searched"),
]


def test_wrong_use_is_refused_with_the_remedy(call: Any, folder: Any, subtests: pytest.Subtests) -> None:
    for arguments, says in WRONG:
        with subtests.test(arguments=arguments, description=says):
            ran = call("ramp", *arguments)
            assert (ran.status, ran.out) == (2, "")
            assert says in ran.err
            assert not list(folder.iterdir())


def test_one_step_is_a_step(call: Any):
    told = call("ramp", "cy525", "F=0", "R=1", "S=255", "--distance", "1").out.split("\n")
    assert told[2] == "ramp          3.636363 ms, 1 step"
    assert told[5] == "1 step        3.636363 ms: crawl 1; reaches 275 steps/s"
