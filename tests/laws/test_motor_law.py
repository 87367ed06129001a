"""A stepper with physics leaves the same edges, whoever looks and when, in whatever blocks it is integrated."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np
import pytest

import slewline
from slewline.parts.motors.drivers import read_driver
from slewline.parts.motors.integration import numba_is_there
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.loads import read_load
from slewline.parts.motors.motors import read_motor
from slewline.parts.steppers import motor_run as runs
from tests.ensembles import few

from .motor_dialogues import DRIVERS, LOADS, UNIPOLAR, Dialogue, blocks, differences, made, nearly, play
from .motor_twin import slow

QUICK = (6, 1, 11, 3, 13, 5, 17, 7, 18, 15, 21)
TWINS = (6, 2, 22, 3, 30)
KINDS = (
    "cy525", "gs-c200s", "mc1151a-e", "fed back", "circle", "carriage", "gear", "stop", "phases", "gs_d200", "levels",
)  # fmt: skip


def ways(dialogue: Dialogue, *, soon: bool) -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """Seven ways to play a dialogue, beside the lazy one."""

    def in_blocks(number: int, **options: Any) -> dict[str, Any]:
        with blocks(Random(f"{number} {dialogue.seed}"), soon=soon and number == 2 and numba_is_there()):
            return play(dialogue, **options).told()

    yield "stepwise", lambda: play(dialogue, stepwise=True).told()
    yield "watched", lambda: play(dialogue, watched=True).told()
    yield "pieces", lambda: play(dialogue, pieces=1).told()
    yield "other pieces", lambda: play(dialogue, pieces=2).told()
    yield "shuffled", lambda: play(dialogue, shuffle=dialogue.seed + 1).told()
    yield "small blocks, pieces", lambda: in_blocks(1, pieces=7)
    yield "other blocks, watched", lambda: in_blocks(2, watched=True)


def same(seed: int, *, soon: bool = False) -> Dialogue:
    """Assert that a dialogue is the same in all eight ways; return it."""
    dialogue = made(seed)
    lazy = play(dialogue).told()
    for name, way in ways(dialogue, soon=soon):
        found = differences(lazy, way())
        assert not found, f"{name}: {found[:3]}\n  {dialogue}"
    return dialogue


def agrees(seed: int) -> None:
    """Assert that the slow twin leaves the same edges."""
    dialogue = made(seed)
    lazy, twin = play(dialogue).edges(), play(dialogue, kind=slow)
    found = differences(lazy, nearly(twin.edges(), lazy, twin.bench["m"].unsure))  # type: ignore[attr-defined]
    assert not found, f"{found[:3]}\n  {dialogue}"


@pytest.mark.parametrize("seed", few(QUICK, 1))
def test_eight_variants_are_the_same(seed: int) -> None:
    same(seed)


@pytest.mark.parametrize("seed", few(TWINS, 1))
def test_the_slow_twin_leaves_the_same_edges(seed: int) -> None:
    agrees(seed)


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("block", range(10))
def test_two_hundred_dialogues_are_the_same_in_eight_variants(block: int) -> None:
    counted: Counter[str] = Counter()
    for seed in range(block * 20, block * 20 + 20):
        counted.update(same(seed, soon=seed % 4 == 0).kinds)
    assert sum(counted[kind] > 0 for kind in KINDS) >= len(KINDS) - 2, counted


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_the_slow_twin_agrees_on_sixty_dialogues() -> None:
    for seed in range(300, 360):
        agrees(seed)


# ------------------------------------------------------------------------------------------------------------ engines
ONE_OF_EACH = [
    *((driver, {}, LOADS[n % len(LOADS)], n % 2) for n, (driver, _) in enumerate(DRIVERS)),
    ("L/4R 20 V", {"motor": UNIPOLAR}, {}, 0),
]


def asked(micro: int) -> tuple[list[int], list[int]]:
    """Edges of a ramp up and back: instants, and commands."""
    rnd = Random(micro)
    times = sorted({rnd.randrange(1, 190_000_000_000) for _ in range(150)})
    return times, [min(n, 150 - n) * micro for n in range(1, len(times) + 1)]


def law_of(driver: Any, motor: Any, load: Any, halves: int) -> MotorLaw:
    its = read_motor(motor)
    steps = ("full", "micro 8")[halves]
    return MotorLaw(its, read_driver(driver, "driver", its), read_load(load, "load", its), steps, 20_000_000)


@pytest.mark.long
@pytest.mark.skipif(not numba_is_there(), reason="Numba is not installed")
@pytest.mark.parametrize("case", ONE_OF_EACH, ids=lambda case: str(case[0]))
def test_numba_gives_the_same_bits_after_ten_thousand_steps(case: Any) -> None:
    driver, options, load, halves = case
    law = law_of(driver, options.get("motor", "QSH4218-51-10-049"), load, halves)
    times, commands = asked(law.micro)
    plain, fast = (law.integrate(times, commands, 230_000_000_000, engine=name) for name in ("python", "numba"))
    assert plain.states.tobytes() == fast.states.tobytes() and (plain.times == fast.times).all()
    assert plain.rests == fast.rests and (plain.commands == fast.commands).all() and (plain.codes == fast.codes).all()


# ------------------------------------------------------------------------------------------ what has gone wrong before
@dataclass
class Moving:
    """A chip in motion with a motor and an encoder."""

    bench: slewline.Bench
    chip: Any
    motor: Any
    encoder: Any

    def told(self) -> tuple[Any, ...]:
        edges = [part.tolist() for pin in ("e.a", "e.b", "m.stall") for part in self.bench.edges(pin)]
        return self.motor.place, self.motor.speed, self.motor.lost, self.encoder.counts, edges


def moving(bench: slewline.Bench | None = None, steps: int = 400, **options: Any) -> Moving:
    bench = slewline.Bench() if bench is None else bench
    chip = bench.add("cy525", "x")
    motor = bench.part("stepper", "m", chip, **{"step": "100 us", **options})
    encoder = bench.part("encoder", "e", on=motor, counts=2000)
    bench.record("e.a", "e.b", "m.stall")
    bench.host(chip).send(f"A 0\rF 10\rR 60\rS 200\rZ 1\rN {steps}\rG\r")
    return Moving(bench, chip, motor, encoder)


def watch(it: Moving) -> None:
    for pin in (it.encoder.pin("a"), it.encoder.pin("b"), it.motor.pin("stall")):
        pin.net.watch(lambda _net: None)


@pytest.mark.parametrize("watched", [False, True])
@pytest.mark.parametrize("looks", [False, True])
def test_actions_at_an_instant_that_has_been_queried_count(watched: bool, looks: bool) -> None:
    def played(watched: bool, looks: bool) -> tuple[Any, ...]:
        it = moving()
        if watched:
            watch(it)

        def look() -> None:
            if looks:
                assert it.motor.place < 1000 and it.encoder.counts < 10_000

        it.bench.run("60 ms")
        for act in (it.motor.block, lambda: it.motor.pin("enable").drive(0)):
            look()
            act()
        look()
        it.bench.run("10 ms")
        it.motor.pin("enable").drive(1)
        for act in (it.motor.free, lambda: it.motor.push(3), it.motor.block, it.motor.free, lambda: it.motor.push(-1)):
            look()
            act()
        it.bench.run("40 ms")
        return it.told()

    assert played(watched, looks) == played(False, False)


def test_a_push_before_time_passes_counts() -> None:
    it = moving(steps=1)
    it.motor.push(4)
    it.bench.run("1 ms")
    assert it.motor.place == pytest.approx(4) and it.encoder.counts == 40
    assert it.motor.lost == -4 and [found.code for found in it.motor.findings] == ["out-of-step", "steps-lost"]


def test_a_push_turns_what_hangs_on_a_coupling_and_ends_at_a_stop() -> None:
    it = moving(steps=1, load={"inertia": "60 g cm2", "stiffness": 3.0, "high": 3.0})
    it.bench.run("1 ms")
    it.motor.push(5)
    state = it.motor._state
    assert state["theta"] == pytest.approx(state["theta2"]) and it.motor.place == pytest.approx(3.0)


def test_the_level_that_a_circle_settles_at_is_that_of_the_beginning() -> None:
    bench = slewline.Bench()
    motor: Any = bench.part("stepper", "m", step="100 us", load={"torque": "30 mNm"})
    bench.part("switch", "s", on=motor, low=10)
    bench.part("inverter", "i")
    bench.wire("s.out", "i.in1")
    bench.wire("i.out", "m.enable")
    bench.run("100 ms")
    assert motor._run.stretches[0].first.state[2:] == (0.0, 0.0)  # no current from the beginning
    assert motor.place < -10  # and the weight sinks


def test_an_origin_of_phases_counts_whether_or_not_the_points_are_recomputed() -> None:
    def place() -> float:
        bench = slewline.Bench()
        bench.add("gs-c200s", "x")
        bench.part("gs_d200", "d", "x")
        motor: Any = bench.part("stepper", "m", inputs="phases", load={"torque": "30 mNm"}, driver="current 1 A")
        for n, phase in enumerate("abcd", 1):
            bench.wire(f"d.{phase}", f"m.phase{n}")
        bench.run("20 ms")
        return float(motor.place)

    assert place() == pytest.approx(-0.11, abs=0.2)  # about its first place


def test_an_encoder_and_a_switch_put_on_later_show_the_same_watched_or_not() -> None:
    def played(watched: bool) -> list[Any]:
        bench = slewline.Bench()
        chip = bench.add("cy525", "x")
        bench.host(chip).send("A 0\rF 10\rR 60\rS 200\rZ 1\rN 400\rG\r")
        bench.run("70 ms")
        motor: Any = bench.part("stepper", "m", chip, step="100 us")
        bench.run("33 ms")
        encoder: Any = bench.part("encoder", "e", on=motor, counts=2000)
        switch: Any = bench.part("switch", "s", on=motor, low=10)
        bench.record("e.a", "s.out")
        if watched:
            encoder.pin("a").net.watch(lambda _net: None)
            switch.pin("out").net.watch(lambda _net: None)
        bench.run("70 ms")
        edges = [part.tolist() for pin in ("e.a", "s.out") for part in bench.edges(pin)]
        return [motor.place, encoder.counts, switch.closed, edges]

    lazy = played(False)
    assert lazy == played(True) and len(lazy[3][0]) > 50


def test_a_finding_has_its_instant_at_any_time_of_the_query() -> None:
    def played(every_ms: int) -> Any:
        it = moving(steps=200)
        for _ in range(200 // every_ms):
            it.bench.run(f"{every_ms} ms")
            it.motor.findings  # noqa: B018
            if it.bench.now_ps == 40_000_000_000:
                it.motor.block()
            if it.bench.now_ps == 80_000_000_000:
                it.motor.free()
        return [(found.time_ps, found.code, found.text) for found in it.motor.findings]

    rare = played(40)
    assert rare == played(1) and len(rare) >= 2


def test_a_long_time_is_integrated_in_stretches() -> None:
    it = moving(steps=50, load={"torque": "30 mNm"})
    it.bench.run("1 s")
    it.motor.pin("enable").drive(0)
    it.bench.run("900 ms")
    assert it.motor.speed < 0
    assert max(stretch.count for stretch in it.motor._run.stretches) < 2 * runs.STRETCH + 1000


def test_an_abort_drops_all_the_stretches_foreseen_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def played() -> Any:
        it = moving(steps=2000)
        watch(it)
        it.bench.run("60 ms")
        it.chip.pin("abort").pulse(0, "1 ms")
        it.bench.run("60 ms")
        return it.motor.place, it.encoder.counts, [part.tolist() for part in it.bench.edges("e.a")]

    whole = played()
    monkeypatch.setattr(runs, "STRETCH", 16)
    assert played() == whole and len(whole[2][0]) > 50


def test_keep_forgets_nothing_that_is_still_to_come() -> None:
    def played(**options: Any) -> Any:
        it = moving(slewline.Bench(**options), steps=2000)
        switch: Any = it.bench.part("switch", "s", on=it.motor, low=30, high=1200)
        watch(it)
        it.chip.pin("abort").pulse(0, "1 s", at="1200 ms")
        for _ in range(18):
            it.bench.run("100 ms")
        return it.motor.place, it.motor.lag, it.motor.lost, it.encoder.counts, switch.closed

    assert played(keep="50 ms") == played()


def test_a_replay_repeats_what_hands_have_done(tmp_path: Any) -> None:
    it = moving(slewline.Bench(journal=tmp_path / "run.jsonl"), load="inertia 20 g cm2")
    it.bench.run("60 ms")
    it.motor.push(2)
    it.bench.run("10 ms")
    it.motor.block()
    it.bench.run("10 ms")
    it.motor.free()
    it.motor.load("30 mNm")
    it.bench.run("10 ms")
    it.motor.load(0.01)
    it.bench.run("50 ms")
    again = slewline.replay(tmp_path / "run.jsonl")
    assert again["m"].place == it.motor.place and again["m"].lost == it.motor.lost  # type: ignore[attr-defined]


def test_a_day_at_rest_is_twenty_events_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    it = moving(steps=50)
    watch(it)
    it.bench.run("500 ms")
    instants = 0
    kernel = it.bench.kernel
    whole = type(kernel)._instant

    def counted(self: Any, *args: Any) -> Any:
        nonlocal instants
        instants += 1
        return whole(self, *args)

    monkeypatch.setattr(type(kernel), "_instant", counted)
    it.bench.run("24 h")
    assert instants <= 20 and it.motor.place == pytest.approx(50)


def test_an_inverted_wire_counts_steps_at_the_other_edge() -> None:
    def place(**options: Any) -> float:
        bench = slewline.Bench()
        chip = bench.add("cy525", "x")
        motor: Any = bench.part("stepper", "m", step="100 us", edge=options.pop("edge"))
        bench.wire("x.pulse", "m.pulse", **options)
        bench.wire("x.direction", "m.direction")
        bench.host(chip).send("A 0\rF 10\rR 60\rS 200\rZ 1\rN 400\rG\r")
        bench.run("100 ms")
        return float(motor.place)

    assert place(edge="fall", invert=True) == place(edge="rise")


def test_a_peak_within_a_step_shows_whether_or_not_it_is_sampled() -> None:
    """The rotor swings past a bound and back between two grid points: both edges are there, looked at or not."""
    quiet = moving(steps=1, step="20 us")
    quiet.bench.run("60 ms")
    (part,) = quiet.motor._run.between(0, quiet.bench.now_ps)
    times, states = part.columns[0], part.columns[1]
    turns = np.flatnonzero((states[:-1, 1] > 0) & (states[1:, 1] < 0))[:6]
    for n in turns.tolist():
        law, t, code = part.law, int(times[n]), int(part.columns[3][n])
        peak = max(law.after(t, states[n].tolist(), code, span)[0] for span in range(0, 20_000_001, 200_000))
        ends = max(states[n, 0], states[n + 1, 0])
        bound = float(ends + (peak - ends) * 0.7) / law.motor.step
        shown = []
        for look in (None, t + 10_000_000, t + 19_999_999):
            it = moving(steps=1, step="20 us")
            it.bench.part("switch", "s", on=it.motor, low=bound)
            it.bench.record("s.out")
            if look is not None:
                it.bench.run_to(look)
                assert it.bench["s"].closed in (False, True)  # type: ignore[attr-defined]
            it.bench.run_to(60_000_000_000)
            shown.append([edges.tolist() for edges in it.bench.edges("s.out")])
        assert shown[0] == shown[1] == shown[2]
        assert sum(t < ps - 1_000_000 <= times[n + 1] for ps in shown[0][0]) == 2
