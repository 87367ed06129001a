"""What a failed comparison says."""

from __future__ import annotations

import pytest

from slewline.testing.differences import difference

WORDS = {1: "cw", -1: "ccw"}
STEPS = [(n * 10**9, 1) for n in range(1, 6)]


def told(found, expected=STEPS, hz=10**12):
    return difference(found, expected, "step", WORDS, hz)


def changed(n, event):
    return [*STEPS[: n - 1], event, *STEPS[n:]]


def test_equality_gives_an_empty_text():
    assert told(list(STEPS)) == ""
    assert told([], []) == ""


def test_one_that_is_late_or_early():
    assert told(changed(4, (4_000_002_500, 1))) == "step 4 is 2.5 ns late: cw at 4.000002 ms, expected cw at 4 ms"
    assert told(changed(1, (1, 1))) == "step 1 is 999.999999 µs early: cw at 1 ps, expected cw at 1 ms"


@pytest.mark.parametrize(
    ("late_ps", "said"),
    [
        (90_909, "1 tick late"),
        (181_818, "2 ticks late"),
        (181_819, "2 ticks late"),  # each of the two instants was rounded down
        (181_820, "181.82 ns late"),
        (90_000, "90 ns late"),
    ],
)
def test_whole_ticks_of_a_crystal_are_reported_as_ticks(late_ps, said):
    assert told(changed(4, (4 * 10**9 + late_ps, 1)), hz=11_000_000).startswith(f"step 4 is {said}: ")


def test_a_wrong_direction():
    assert told(changed(2, (2 * 10**9, -1))) == "step 2 is ccw at 2 ms, expected cw"


def test_one_that_is_missing_or_too_many_does_not_make_all_others_wrong():
    assert told(STEPS[:2] + STEPS[3:]) == "step 3 is missing: expected cw at 3 ms"
    assert told([*STEPS[:3], (3_500_000_000, 1), *STEPS[3:]]) == "step 4 is one too many: cw at 3.5 ms"


def test_how_many_more_there_are():
    found = [(time + 10**6 * (n > 1), sign) for n, (time, sign) in enumerate(STEPS)]
    assert told(found) == "step 3 is 1 µs late: cw at 3.001 ms, expected cw at 3 ms; 2 more errors"
    assert told(found[:4]).endswith("; 1 more error; 4 steps found, expected 5")


def test_missing_steps_at_the_end():
    assert told(STEPS[:3]) == "2 steps missing at the end: 3 found, expected 5; the first is cw at 4 ms"
    assert told(STEPS[:4]) == "1 step missing at the end: 4 found, expected 5; the first is cw at 5 ms"
    assert told(STEPS, STEPS[:2]) == "3 steps too many at the end: 5 found, expected 2; the first is cw at 3 ms"
