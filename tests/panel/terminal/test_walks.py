"""The debugger walked through by its keys, against a real server, with snapshots of what is seen."""

from __future__ import annotations

import pytest

from .walks import EXAMPLES, PAGE, SIZES, SNAPSHOTS, on_page, walked

pytestmark = pytest.mark.check
WELD = str(EXAMPLES / "programs/weld.cy525")
SEGMENTS = str(EXAMPLES / "programs/segments.gs-c200s")


@pytest.mark.parametrize("snapshot", SNAPSHOTS, ids=lambda snapshot: snapshot.name)
def test_the_screens_match(snapshot):
    """`python -m tests.panel.terminal.refresh` writes it down anew."""
    for size, seen in snapshot.seen().items():
        assert seen == snapshot.path(size).read_text("utf-8")


@pytest.mark.parametrize("size", SIZES)
def test_every_row_fits(size):
    for snapshot in SNAPSHOTS:
        rows = snapshot.path(size).read_text("utf-8").splitlines()
        assert len(rows) == SIZES[size][1]
        assert max(map(len, rows)) <= SIZES[size][0]


def test_the_page_shows_it():
    assert on_page() in PAGE.read_text("utf-8")


def test_a_program_is_stopped_at_a_jump_stepped_and_taken_back():
    async def way(walk):
        await walk.say(":break 12")
        await walk.press("space")
        await walk.stopped("at instruction 12")
        first = walk.session.now_ps
        await walk.press("s")
        assert walk.session.chips["gs_c200s"]["counter"] == 18  # UI1 is high: the jump is taken
        await walk.say(f":time {first} ps")
        assert walk.session.chips["gs_c200s"]["counter"] == 12
        assert walk.session.now_ps == first
        await walk.say(":drive ui1 0")
        await walk.press("s")
        assert walk.session.chips["gs_c200s"]["counter"] == 14  # another branch
        assert "branch 1" in walk.screen

    walked([SEGMENTS], SIZES["80x24"], way)


def test_time_goes_back_and_on_by_the_arrows():
    async def way(walk):
        await walk.say(":time 1.25 s")
        await walk.press("left")
        assert walk.session.now_ps == 250 * 10**9
        await walk.press("shift+right")
        assert walk.session.now_ps == 350 * 10**9
        await walk.press("ctrl+right")
        assert walk.session.now_ps == 360 * 10**9

    walked([WELD], SIZES["80x24"], way)


def test_the_space_bar_starts_and_stops_time():
    async def way(walk):
        await walk.press("]", "]", "]")
        assert walk.session.rate == 10
        await walk.pilot.press("space")
        await walk.pilot.pause(0.3)
        assert not walk.session.paused
        await walk.press("space")
        assert walk.session.paused
        assert walk.session.now_ps > 10**12

    walked([WELD], SIZES["80x24"], way)


def test_a_row_is_run_to_and_a_breakpoint_taken_away():
    async def way(walk):
        await walk.say(":time 15 ms")
        await walk.press("end", "up", "u")
        assert walk.session.chips["cy525"]["counter"] == 17
        await walk.press("b")
        assert walk.session.breakpoints == [{"chip": "cy525", "address": 17}]
        assert "●▶17" in walk.screen
        await walk.press("b")
        assert walk.session.breakpoints == []
        assert "●" not in walk.screen

    walked([WELD], SIZES["80x24"], way)


def test_the_next_edge_of_a_pin_and_a_position():
    async def way(walk):
        await walk.pilot.press("e", *"programmable", "tab")
        await walk.press("enter")
        assert walk.session.why == "next edge of cy525.programmable_output"
        await walk.pilot.press("e")
        assert walk.app.query_one("#command").value == ":edge programmable_output"
        await walk.press("escape")
        await walk.pilot.press("p", *"250")
        await walk.press("enter")
        assert walk.session.chips["cy525"]["axes"][0]["position"] == 250

    walked([WELD], SIZES["80x24"], way)


def test_a_wait_that_does_not_end_is_ended_by_the_space_bar():
    async def way(walk):
        await walk.pilot.press("p", *"30000", "enter")
        await walk.pilot.pause(0.3)
        assert walk.session.doing == "cy525 at position 30000"
        await walk.press("space")
        assert walk.session.paused
        assert not walk.session.doing

    walked([WELD, "--strap", "dowhile=0"], SIZES["80x24"], way)


def test_a_chip_alone_takes_commands_and_findings_are_shown():
    async def way(walk):
        await walk.say("N 40")
        await walk.say("R 200")
        await walk.say(":time +20 ms")
        assert walk.session.chips["cy525"]["registers"]["number"] == 40
        assert "range: RATE 200" in walk.screen
        assert "1 finding" in walk.screen
        await walk.pilot.press("slash", "up")
        assert walk.app.query_one("#command").value == ":time +20 ms"
        await walk.pilot.press("up")
        assert walk.app.query_one("#command").value == "R 200"

    walked(["cy525"], SIZES["80x24"], way)


@pytest.mark.parametrize(
    ("typed", "says"),
    [
        (":rate 0", "rate '0'; expected virtual seconds per second, 0.001 to 1000"),
        (":go nan", "rate 'nan'; expected virtual seconds per second"),
        (":break 200", "cy525: instruction at 200; allowed 0..59, the addresses of a program"),
        (":break 50", "no instruction begins at 50 now"),
        (":break 6a", "break '6a'; expected ADDRESS, pin PIN [EDGE], register NAME"),
        (":break", "break: expected ADDRESS, pin PIN [EDGE], register NAME"),
        (":power maybe", "power 'maybe'; expected 'on' or 'off'"),
        (":edge slew fals", "edge 'slew fals'; expected a pin, and optionally 'rises', 'falls' or 'any'"),
        (":drive wait", "drive 'wait'; expected a pin and a level, such as :drive wait 0"),
        (":act table", "act 'table'; expected a part and a verb"),
        (":edge ascii_binary", "not reached within 3600 s of virtual time; no command or program is in progress"),
        (":edge ascii_binary", "; :time 0.015 goes back"),
        (":break pin slew low", "break: edge 'low'; allowed 'rises', 'falls', 'any'"),
        (":drive wait low", "drive: level 'low'; allowed 0 and 1"),
        ("break 6", "break 6 is not a command of cy525; a verb of the debugger begins with a colon"),
        ("quit", "quit is not a command of cy525; q leaves the debugger"),
        ("run", "run is not a command of cy525; :go lets time run"),
        (":until 200", "until: no instruction begins at 200"),
        (":clear 6", "clear '6'; expected no argument; use :break 6 to remove only that breakpoint"),
        ("HELP", "HELP is not a command of cy525; ? shows the help of the debugger"),
        ("R 100", "R 100: can be sent only while time runs, but time is paused: press Esc, then"),
    ],
)
def test_a_mistake_is_answered_at_the_foot(typed, says):
    async def way(walk):
        await walk.say(":time 15 ms")  # a program is stored
        await walk.say(typed)
        assert says in walk.session.trouble
        assert says.startswith(";") or says[:40] in walk.screen

    walked([WELD], SIZES["80x24"], way)


def test_a_line_is_completed_and_explained():
    async def way(walk):
        await walk.pilot.press("colon", *"dri", "tab", "space", *"dowh", "tab", "space", "0")
        assert walk.app.query_one("#command").value == ":drive dowhile 0"
        seen = await walk.settle()
        assert ":drive PIN LEVEL  drive a pin to a level" in seen
        await walk.press("enter")
        await walk.say(":time 1 ms")
        assert walk.session.chips["cy525"]["levels"]["dowhile"] == 0
        await walk.pilot.press("slash", "S")
        assert "SLOPE" in await walk.settle()

    walked([WELD], SIZES["80x24"], way)


def test_impossible_requests_are_reported():
    async def way(walk):
        assert "no verb 'brake'; allowed: go," in await walk.say(":brake 7")
        assert "no pin 'foo'" in await walk.say(":edge foo")
        assert "rate 'fast'; expected" in await walk.say(":rate fast")

    walked([WELD], (120, 30), way)


def test_no_colour_and_light(monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("COLORFGBG", "0;15")

    async def way(walk):
        assert walk.app.theme == "textual-light"
        await walk.press("d")
        assert walk.app.theme == "textual-dark"
        assert "position 0" in walk.screen

    walked([WELD], SIZES["80x24"], way)


def test_a_server_that_ends_ends_the_debugger():
    async def way(walk):
        await walk.session.client.request("quit")
        for _ in range(100):
            await walk.pilot.pause(0.05)
            if walk.app._exit:
                return
        raise AssertionError("it goes on")

    walked([WELD], SIZES["80x24"], way)
