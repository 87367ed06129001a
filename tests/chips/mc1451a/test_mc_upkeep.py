"""What a chipset that runs for hours costs and keeps: it does not grow with what a host writes, nor with nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from mc import ONE, Rig, base, each

import slewline
from slewline.errors import NotRecorded

FOR_HOURS = ("SET_PRFL_VEL", f"SET_VEL {ONE // 16}", "SET_ACC 0x100")


def events(rig: Rig, time: str) -> int:
    """How many events the kernel is told to come, while a time passes."""
    before = next(rig.bench.kernel.order)
    rig.bench.run(time)
    return next(rig.bench.kernel.order) - before - 1


@each
def test_writes_of_a_host_during_a_motion_leave_nothing_in_the_kernel(part: str) -> None:
    rig = base(part)
    rig.begin(*FOR_HOURS)
    for number in range(100):
        rig.do(f"SET_POS {number}", "UPDATE")
        rig.next(2)
    assert len(rig.bench.kernel.heap) < 5


@each
def test_resets_during_motions_leave_nothing_in_the_kernel_that_grows(part: str) -> None:
    rig = base(part)
    for _ in range(20):
        rig.begin(*FOR_HOURS)
        rig.bench.run("1 s")
        rig.x.reset()
        rig.bench.run("10 ms")
    assert len(rig.bench.kernel.heap) < 5
    n = rig.begin("SET_VEL 0x10000", "SET_ACC 0x10000", "SET_POS 3")
    rig.rest()
    assert rig.pulses(rig.at(n)) == [rig.at(n + k) for k in (1, 2, 3)]


@pytest.mark.parametrize(
    ("mode", "limit", "most"),
    [
        (FOR_HOURS, 32767, 10),  # the error is as great as can be told, and the limit is just that
        (
            ("SET_PRFL_S_CRV", f"SET_VEL {ONE // 16}", "SET_MAX_ACC 0x100", "SET_JERK 0x1000", f"SET_POS {1 << 29}"),
            100,
            400,
        ),
    ],
    ids=["velocity", "s-curve"],
)
def test_an_encoder_that_is_not_mounted_costs_next_to_nothing(mode: tuple[str, ...], limit: int, most: int) -> None:
    rig = base("mc1151a-e")
    rig.do("SET_STEP_RATIO 2560", f"SET_POS_ERR {limit}")
    rig.begin(*mode)
    rig.bench.run("30 s")
    rig.do("SET_ACTL_POS 0") if limit == 100 else rig.bench.run("30 s")
    assert events(rig, "1000 s") < most


def test_an_axis_forgets_its_cycles_with_its_steps() -> None:
    rig = base("mc1151a-e")
    rig.do("SET_PRFL_GEAR", f"SET_RATIO {ONE}", "UPDATE")
    rig.turn(400, 8192)
    rig.bench.run("100 ms")
    axis, now = rig.x.axis(1), rig.bench.now_ps
    rig.bench.run("50 ms")
    before = axis.cycles(now)
    axis.motor.forget(now)
    after = axis.cycles()
    with pytest.raises(NotRecorded):
        axis.cycles(0, now)
    assert after.targets[-len(before) :].tolist() == before.targets.tolist()
    assert len(before) > 100 and len(axis.motor.past) < 200 and len(rig.x._motion.trajectories[0].pulses.past) < 200


@each
def test_positions_that_were_declared_are_forgotten_too(part: str) -> None:
    rig = base(part)
    for number in range(50):
        rig.do(f"SET_ACTL_POS {number}")
    n = rig.begin("SET_VEL 0x10000", "SET_ACC 0x10000", "SET_POS 53")
    rig.rest()
    steps = rig.x.steps(rig.at(n))
    rig.x.motor.forget(rig.at(n))
    kept = rig.x.steps(rig.at(n))
    assert kept.positions.tolist() == steps.positions.tolist() == [50, 51, 52, 53]
    assert rig.x.position_at(rig.at(n + 2)) == 51 and len(rig.x.motor.offsets) == 1


@pytest.mark.parametrize("cold", [False, True])
def test_before_its_first_cycle_a_chipset_has_no_cycles_and_a_plot_reports_it(cold: bool, tmp_path: Path) -> None:
    bench = slewline.Bench()
    axis = bench.add("mc1151a", cold=cold).axis(1)
    assert len(axis.cycles()) == len(axis.cycles(0, "1 s")) == len(axis.steps()) == 0
    with pytest.raises(slewline.UsageError, match="nothing to draw from 0 ps to 0 ps"):
        bench.plot(tmp_path / "empty.svg")
    bench.run("5 ms")
    assert axis.cycles().numbers.tolist() == ([] if cold else list(range(16)))
    if cold:  # there is nothing but rest to be drawn
        bench.plot(tmp_path / "rest.svg")
        assert (tmp_path / "rest.svg").stat().st_size
