"""Figures, times and curves as text."""

from __future__ import annotations

import asyncio

import pytest

from slewline.panel.terminal import session
from slewline.panel.terminal.session import CURVE_COLUMNS, DebugSession, columns
from slewline.panel.terminal.text_drawing import clock, figure, line, pair, spread, stamp, strip


def test_a_line_has_its_width():
    assert line(8, "one").plain == "one     "
    assert line(8, ("one two", "bold"), " three").plain == "one two…"
    assert "".join(text for text, _ in pair(12, "programmable", "1")) == "programma… 1"


def test_times_and_figures():
    assert clock(1_234_567_890_123) == "1.234 567 s"
    assert stamp(1_234_567_890_123) == "1.234567"
    assert [figure(each) for each in (0, 18.46, 500.0, 1234.5)] == ["0", "18.5", "500", "1234"]


def test_a_strip_is_filled_from_below():
    assert strip([0, 0, 8, 8, None, None], 3, 1, 8) == ["⣀⣿⠀"]
    assert strip([0, 8], 1, 2, 8) == ["⢸", "⣸"]
    assert strip([], 2, 1, 0) == ["⠀⠀"]
    assert strip([-8, -8], 1, 1, 8) == ["⣿"]


def test_of_several_values_the_greatest_counts():
    assert spread([1, None, -5, 2], 2) == [1, -5]
    assert spread([1, 2], 4) == [1, 1, 2, 2]
    assert spread([], 2) == [None, None]


@pytest.mark.parametrize(("time", "first"), [(0, 0), (500, CURVE_COLUMNS // 2)])
def test_a_quantity_keeps_its_value_from_its_time(time, first):
    found = columns({"times_ps": [time], "values": [7.0]}, 0, 1000)
    assert found == [None] * first + [7.0] * (CURVE_COLUMNS - first)


def test_curves_are_requested_once_for_each_instant(monkeypatch):
    monkeypatch.setattr(session, "CURVE_EVERY_S", 0)
    requested = []

    class Client:
        """The client of a bench whose instant changes at every second look."""

        def __init__(self):
            self.view, self.looks = {"chips": {"x": {}}}, [1000, 1000, 2000, 2000]

        @property
        def open(self):
            self.now_ps = self.looks.pop(0) if self.looks else None
            return self.now_ps is not None

        async def request(self, verb, **keys):
            requested.append((verb, keys["signals"], keys["stop"]))
            return {"signals": {}}

    shown = DebugSession("nowhere")
    shown.client, shown.quantities = Client(), ["x.velocity"]
    asyncio.run(shown._draw_curves())
    assert requested == [("window", ["x.velocity"], stop) for stop in (1000, 2000)]


def test_a_break_is_left_out():
    found = columns({"times_ps": [0, 250, 500], "values": [1.0, None, 2.0]}, 0, 1000)
    quarter = CURVE_COLUMNS // 4
    assert found[quarter - 1] == 1 and found[quarter + 1] is None and found[-1] == 2
