"""Properties of a program, for any input: a new module for each example, closed at its end."""

import serial
from feeder import FORMAT, Feeder
from hypothesis import given, settings
from hypothesis import strategies as st

STEPS = st.integers(-300, 300).filter(bool)


@settings(max_examples=25, deadline=None)
@given(steps=STEPS)
def test_any_sheet_is_fed(slewline_for_session, steps):
    with (
        slewline_for_session("gs-c200s", straps={"chs": 0}) as module,
        serial.serial_for_url(module.url, 9600, **FORMAT) as port,
    ):
        feeder = Feeder(port)
        feeder.feed(steps)
        feeder.wait()
        assert feeder.position == steps


@settings(max_examples=15, deadline=None)
@given(moves=st.lists(STEPS, max_size=4), seed=st.integers(0, 99))
def test_moves_add_up_whatever_a_lost_answer_does(slewline_for_session, moves, seed):
    with (
        slewline_for_session("gs-c200s", straps={"chs": 0}, seed=seed) as module,
        serial.serial_for_url(module.url, 9600, **FORMAT) as port,
    ):
        feeder = Feeder(port)
        for steps in moves:
            feeder.feed(steps)
            feeder.wait()
        module.faults.lost_byte(to="host", count=4)
        try:
            feeder.ask("V1")
        except TimeoutError:
            port.reset_input_buffer()
        assert feeder.position == sum(moves)
