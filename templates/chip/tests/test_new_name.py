"""The facts of the NEW-NAME: each test proves the facts of conformance.toml that it names."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import slewline

from new_name import NewName

Ask = Callable[[str], str]


@pytest.fixture
def bench() -> slewline.Bench:
    """Return a bench; its virtual time begins at 0."""
    return slewline.Bench()


@pytest.fixture
def x(bench: slewline.Bench) -> NewName:
    """Return the chip on the bench, powered up."""
    return bench.add(NewName, name="x")


@pytest.fixture
def ask(bench: slewline.Bench, x: NewName) -> Ask:
    """Return the function of a host that sends a command and returns the answer."""
    return bench.host(x).ask


@pytest.mark.fact("LINE", "ANSWER", "CMD-P")
def test_a_host_gets_an_answer(x: NewName, ask: Ask) -> None:
    assert (x.baud, ask("P"), ask("V500")) == (9600, "0", "OK")
    assert (ask("X"), ask("V0"), ask("M")) == ("?", "?", "?")
    assert [finding.code for finding in x.findings] == ["refused"] * 3


@pytest.mark.fact("CMD-V", "CMD-M")
@pytest.mark.parametrize(("command", "position"), [("M40", 40), ("M-40", -40)])
def test_a_move_has_its_steps_at_the_set_speed(
    bench: slewline.Bench, x: NewName, ask: Ask, command: str, position: int
) -> None:
    assert (ask("V500"), ask(command)) == ("OK", "OK")
    bench.run_until_idle()
    times = x.steps().times_ps
    assert (x.position, len(times), set((times[1:] - times[:-1]).tolist())) == (position, 40, {2 * 10**9})
    assert x.pin("dir").level == (position > 0)


@pytest.mark.fact("CMD-V")
def test_the_speed_at_power_up(bench: slewline.Bench, x: NewName, ask: Ask) -> None:
    ask("M2")
    bench.run_until_idle()
    first, second = x.steps().times_ps
    assert second - first == 10**10


@pytest.mark.fact("CMD-S")
def test_a_stop_is_immediate(bench: slewline.Bench, x: NewName, ask: Ask) -> None:
    ask("M1000")
    assert (ask("S"), 0 < x.position < 10) == ("OK", True)
    stopped = x.position
    bench.run("1 s")
    assert (x.position, ask("P")) == (stopped, str(stopped))
    assert ask("M5") == "OK"


@pytest.mark.fact("BUSY")
def test_a_second_move_is_refused(x: NewName, ask: Ask) -> None:
    assert (ask("M1000"), ask("M5")) == ("OK", "?")
    assert [finding.code for finding in x.findings] == ["busy"]


@pytest.mark.fact("PIN-STEP")
def test_the_step_pin_is_low_for_two_microseconds(bench: slewline.Bench, ask: Ask) -> None:
    bench.record("x.step")
    ask("M3")
    bench.run_until_idle()
    falls_and_rises, _ = bench.edges("x.step")
    assert (falls_and_rises[1::2] - falls_and_rises[::2]).tolist() == [2 * 10**6] * 3
