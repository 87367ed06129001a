"""A keyboard whose strobe is made from the byte."""

from __future__ import annotations

import pytest


@pytest.mark.fact("CIRCUIT-KEYBOARD")
def test_each_key_press_transfers_exactly_one_byte(circuit):
    c = circuit("x.instrobe", "x.io_request", "x.ready")
    c.part("keyboard", to="x").type("C\rB\rA 1234\r")
    c.finish()
    assert len(c.falls("x.instrobe")) == 11
    assert c.x.position == 1234
    assert c.level("x.programmable_output") == 1
    assert c.rises("x.io_request") == c.falls("x.ready")  # READY low clears the strobe
    assert c.bench.findings == []
    assert c.bench.now_ps == 11 * (80 + 120) * 10**9


@pytest.mark.fact("CIRCUIT-KEYBOARD")
def test_ready_high_again_makes_no_second_strobe_while_the_key_is_still_down(circuit):
    c = circuit("x.instrobe", "x.ready")
    c.part("keyboard", to="x", down="1 s").type("C")
    c.finish()
    assert len(c.rises("x.ready")) == 1
    assert c.rises("x.ready")[0] < 10**9  # long before the key comes up
    assert len(c.falls("x.instrobe")) == 1


@pytest.mark.fact("CIRCUIT-KEYBOARD")
def test_a_key_that_is_pressed_in_a_motion_makes_no_strobe(circuit):
    c = circuit("x.io_request", rate=3, firstrate=3, slope=255, divisor=1)
    keys = c.part("keyboard", to="x")
    c.settle()
    c.bench.run("1 us")
    keys.type("N 300\rG\r")
    c.bench.run_until(lambda: len(keys.queue) == 0)
    keys.type("C")
    c.bench.run_until(lambda: len(keys.queue) == 0)
    assert c.codes("keyboard") == ["key-lost"]
    assert len(c.falls("x.io_request")) == len("N 300\rG\r")
    c.finish()
    assert len(c.x.steps()) == 300


def test_a_key_kept_down_until_ready_is_taken_then(circuit):
    c = circuit("x.io_request", "x.ready", rate=3, firstrate=3, slope=255, divisor=1)
    keys = c.part("keyboard", to="x", down="400 ms")
    keys.type("N 300\rG\r")  # one second of steps
    c.settle()
    c.bench.run_until(lambda: len(keys.queue) == 0)
    c.bench.run("300 ms")
    keys.type("C")
    c.finish()
    assert c.codes("keyboard") == []
    assert c.falls("x.io_request")[-1] == c.rises("x.ready")[-2]
