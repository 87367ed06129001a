"""RESET and supply, in every state of the chip, and what the chip says that it waits for in each of them."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import slewline
from slewline.chips.cy5xx import firmware as family
from slewline.chips.cy5xx.sheet import POWER_UP_RC_PS
from slewline.chips.cy525 import firmware
from slewline.chips.cy525.sheet import SHEET
from slewline.core import chip as chip_base
from tests.ensembles import few

US, MS = 11, 11_000
STROBE, SAMPLE, BUSY, LETTER = 165, 176, 286, 2057
STEP, HIGH = 11_000, 28
RESET = 90  # clocks: 15 us at 6 MHz
LEAD = 10 * US  # a motion sets its lines so long before its first step
KNOWN = {"rate": 10, "firstrate": 10, "slope": 250, "divisor": 1, "position": 0}
FIVE = {"number": 5, **KNOWN}
ZERO = "G at rate 0, waiting for a rate above 20, or abort=0"
ENDLESS = {**KNOWN, "rate": 20, "number": 64_000}
OUTPUTS = tuple(pin.name for pin in SHEET.pins if pin.reset is not None and pin.in_out in ("out", "both"))
REST = {
    "io_request": 1,
    "io_select": 0,
    "step_inhibit": 0,
    "abort": 1,
    "wait": 1,
    "prog": None,
}  # inputs as a host leaves them


def waiting(h):
    return h.x.waiting.removeprefix("x: ").rpartition(" since ")[0]


def outputs(h):
    return {name: h.x.pin(name).level for name in OUTPUTS if name != "prog"}


HIGH_ALL = dict.fromkeys(sorted(set(OUTPUTS) - {"prog"}, key=OUTPUTS.index), 1)


def rest(h):
    for name, level in REST.items():
        h.put(h.now, name, level)
    h.data(h.now, None)


# ------------------------------------------------------------------------- states of the chip, and how to get into them


def last(h, data, clocks, up=300):
    """Send all but the last byte; give that one, I/O REQUEST being low for `up` clocks, and let some clocks pass."""
    h.send(data[:-1])
    h.strobe(h.now, ord(data[-1]), up=h.now + up)
    h.run(clocks)


def step_in(h, clocks=STEP // 2):
    """Some clocks behind the begin of the first step."""
    h.bench.run_until(lambda: h.x.travel != 0)
    h.run(clocks)


def moving(h, data="G\r", clocks=STEP // 2):
    last(h, data, 400)
    step_in(h, clocks)


def held(h, released=False):
    moving(h)
    h.put(h.now, "step_inhibit", 1)
    h.run(STEP)
    if released:
        h.put(h.now, "step_inhibit", 0)
        h.until(pulse=1)
        h.run(5)


def at_rate_zero(h, up=True, rate=None):
    moving(h, "H\rG\r", 80 * STEP)
    h.strobe(h.now, 0, up=h.now + (STEP if up else 100 * STEP))
    h.run(2 * STEP)
    if rate is not None:
        h.put(h.now, "step_inhibit", 1)
        h.strobe(h.now, rate, up=h.now + STEP)
        h.run(2 * STEP)


def program(h, *lines, clocks=0, level=1):
    h.put(h.now, "wait", level)
    h.send("E\r" + "".join(line + "\r" for line in lines) + "QX\r")
    h.run(clocks)


def live(h, data="", clocks=0):
    program(h, "D 5", "B", "X", clocks=1000)
    h.put(h.now, "prog", 0)
    h.run(60_000)
    if data:
        last(h, data, clocks)


def reading(h, clocks, up=None):
    h.send("V 3\r")
    h.put(h.now, "io_select", 1)
    start = h.now
    h.put(start, "io_request", 0)
    if up is not None:
        h.put(start + up, "io_request", 1)
    h.run_to(start + clocks)


def unknown(h):
    h.send("E\rN 127\rQJ 1\r")  # 7F is no opcode
    h.run(100)


def ended_wait(h):
    program(h, "U", "0", clocks=5000)
    h.put(h.now, "io_request", 0)
    h.run(5000)


STATES = {
    "idle": ("waiting for a command", {}, lambda h: h.run(1000)),
    "INSTROBE is due": ("waiting for a command", {}, lambda h: last(h, "B", 170)),
    "READY is about to fall": ("handling a byte", {}, lambda h: last(h, "B", 200)),
    "a letter is decoded": ("handling a byte", {}, lambda h: last(h, "B", 1000)),
    "half a command": ("waiting for the rest of a command", {}, lambda h: h.send("R 1")),
    "a command is stored": ("handling a byte", {}, lambda h: last(h, "E\rN 300\r", 1000)),
    "I/O REQUEST stays low": (
        "waiting for io_request=1 (then READY rises)", {}, lambda h: last(h, "B\r", 5000, up=9000),
    ),
    "a command is in work": ("N 300 in progress", {}, lambda h: last(h, "N 300\r", 1000)),
    "Q is in work": ("Q in progress", {}, lambda h: last(h, "E\rQ", 500)),
    "G is in work": ("G in progress", FIVE, lambda h: last(h, "G\r", 3000)),
    "G sets its lines": ("G in progress", FIVE, lambda h: last(h, "G\r", 660 * US - LETTER - LEAD + 10)),
    "D": ("waiting 500 ms (D 500)", {}, lambda h: last(h, "D 500\r", 100_000)),
    "O pulses": ("O 200 in progress", {}, lambda h: last(h, "O 200\r", BUSY + (80 + 120 - 17) * US + 100)),
    "U, its request still low": ("waiting for wait=0 (U)", {}, lambda h: last(h, "U\r", 5000, up=9000)),
    "U": ("waiting for wait=0 (U)", {}, lambda h: last(h, "U\r", 5000)),
    "U, the look is due": (
        "waiting for wait=0 (U)", {}, lambda h: (last(h, "U\r", 5000), h.put(h.now + 30, "wait", 0), h.run(31)),
    ),
    "W in a program": ("waiting for wait=1 (W)", {}, lambda h: program(h, "W", "0", clocks=5000, level=0)),
    "the request that ended U": ("waiting for io_request=1 (its low ended a wait)", {}, ended_wait),
    "G, its request still low": (
        "waiting for io_request=1 before the first step (G)", FIVE, lambda h: last(h, "G\r", 9000, up=90_000),
    ),
    "inhibited": (
        "G held by step_inhibit=1", FIVE, lambda h: (h.put(h.now, "step_inhibit", 1), last(h, "G\r", 9000)),
    ),
    "stepping": ("G in motion (5 steps)", FIVE, moving),
    "to a position": ("P 5 in motion (5 steps)", KNOWN, lambda h: moving(h, "P 5\r")),
    "ramping": ("G in motion (800 steps)", {**KNOWN, "number": 800, "rate": 60}, lambda h: moving(h, clocks=12 * STEP)),
    "held in a step": ("G held by step_inhibit=1", FIVE, held),
    "a held step ends": ("G held by step_inhibit=1", FIVE, lambda h: held(h, released=True)),
    "READY is due": ("waiting for READY after G", FIVE, lambda h: moving(h, clocks=5 * STEP + 20)),
    "endless": ("G in motion (until abort=0)", ENDLESS, lambda h: moving(h, "H\rG\r", 30 * STEP)),
    "endless, ABORT low from the start": (
        "G in motion (until RESET, because abort was low at the start)", ENDLESS,
        lambda h: (h.put(h.now, "abort", 0), moving(h, "H\rG\r", 30 * STEP)),
    ),
    "aborted": (
        "G aborted: decelerating to rate 10 (it then continues to its target unless abort=0)", ENDLESS,
        lambda h: (moving(h, "H\rG\r", 50 * STEP), h.put(h.now, "abort", 0), h.run(STEP)),
    ),
    "rate zero, request low": (ZERO, ENDLESS, lambda h: at_rate_zero(h, up=False)),
    "rate zero": (ZERO, ENDLESS, at_rate_zero),
    "rate zero, inhibited": ("G held by step_inhibit=1", ENDLESS, lambda h: at_rate_zero(h, rate=30)),
    "nothing to execute": (
        "run mode with nothing to execute, waiting for a live 0 or RESET", {}, lambda h: program(h, clocks=9000),
    ),
    "an instruction": ("B at byte 0 in progress", {}, lambda h: program(h, "B", "X", clocks=100)),
    "a later instruction": ("C at byte 1 in progress", {}, lambda h: program(h, "B", "C", "X", clocks=600)),
    "an unknown opcode": ("byte 1, 7F, is skipped", {}, unknown),
    "D in a program": ("waiting 5 ms (D 5)", {}, lambda h: program(h, "D 5", "X", clocks=9000)),
    "O pulses in a program": ("O at byte 0 in progress", {}, lambda h: program(h, "O 200", "X", clocks=500)),
    "P in a program sets its lines": (
        "P at byte 1 in progress", {**KNOWN, "position": 9},
        lambda h: (program(h, "B", "P 0", "X"), h.until(ready=0)),
    ),
    "G in a program": ("G in motion (5 steps)", FIVE, lambda h: (program(h, "G", "X"), step_in(h))),
    "READY is due in a program": (
        "waiting for READY after G", FIVE, lambda h: (program(h, "G", "X"), step_in(h, 5 * STEP + 20)),
    ),
    "live": ("waiting for a live command", {}, live),
    "half a live command": ("waiting for the rest of a command", {}, lambda h: (live(h), h.send("R 1"))),
    "a live command is in work": ("R 50 in progress", {}, lambda h: live(h, "R 50\r", 600)),
    "a live D": ("waiting 5 ms (D 5)", {}, lambda h: live(h, "D 5\r", 9000)),
    "a verify byte comes": ("waiting for io_request=1 (after a verify byte)", {}, lambda h: reading(h, 200)),
    "a verify byte stands": ("waiting for io_request=1 (after a verify byte)", {}, lambda h: reading(h, 900)),
    "a verify byte goes": ("waiting for io_request=1 (after a verify byte)", {}, lambda h: reading(h, 700, up=500)),
}  # fmt: skip


def brought(hand, name, *watched, **more):
    _, options, enter = STATES[name]
    h = hand(*watched, **options, **more)
    h.run_to(15)
    enter(h)
    return h


# -------------------------------------------------------------------------------------------------- waits and resets


@pytest.mark.parametrize("name", list(STATES))
def test_the_chip_reports_its_cause_of_waiting(hand, name):
    h = brought(hand, name)
    assert waiting(h) == STATES[name][0]
    assert h.x.idle == (name == "idle" or name == "half a command")
    since = h.x.waiting.rpartition(" since ")[2].partition(";")[0]  # behind it, what has come of a command
    assert slewline.core.time.timebase.picoseconds(since) <= h.bench.now_ps
    if not h.x.idle:
        with pytest.raises(slewline.Timeout) as caught:
            h.bench.run_until_idle(timeout="1 ps")
        assert f"\n  {h.x.waiting}" in str(caught.value)


def recovered(h):
    """RESET has risen: the chip is as after power-up, but for its parameters."""
    assert outputs(h) == HIGH_ALL
    assert h.x.pin("prog").level == 1
    assert h.x.bus.level is None
    assert waiting(h) == "waiting for a command"
    assert h.x.idle
    assert h.x.program == b""
    registers = {**h.x.registers}
    h.send("C\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.x.registers == registers
    h.send("-\rN 2\rR 60\rF 60\rG\r")
    assert h.x.position == (registers["position"] - 2) % 65536
    assert h.x.pin("ready").level == 1


@pytest.mark.fact("RESET-5", "RESET-3", "RESET-4", "PROG-7", "PIN-4")
@pytest.mark.parametrize("name", list(STATES))
def test_a_reset_in_any_state_brings_the_chip_back(hand, name):
    h = brought(hand, name)
    low = h.now
    h.put(low, "reset", 0)
    h.run(RESET)
    assert outputs(h) == HIGH_ALL
    assert waiting(h) == "waiting for RESET high"
    assert not h.x.idle
    rest(h)
    travel, position = h.x.travel, h.x.position
    h.run(100_000)
    assert waiting(h) == "waiting for RESET high"  # it stays there as long as RESET is low
    assert (h.x.travel, h.x.position) == (travel, position)
    h.put(h.now, "reset", 1)
    recovered(h)


def stack(task):
    """(file, line) of every await in which a task is suspended."""
    found, waiter = set(), task.coroutine
    while waiter is not None:
        frame = getattr(waiter, "cr_frame", None) or getattr(waiter, "gi_frame", None)
        if frame is not None:
            found.add((frame.f_code.co_filename, frame.f_lineno))
        waiter = getattr(waiter, "cr_await", None) or getattr(waiter, "gi_yieldfrom", None)
    return found


FIRMWARE = [
    path
    for folder in (firmware, family)
    for path in sorted(Path(folder.__file__).parent.glob("*.py"))
    if path.name != "twin.py"
]
NEVER_SUSPENDED = {
    "return down if self.continuous else await self.rate_request(down, 0)"
}  # a normal motion halts at once


@pytest.mark.fact("RESET-5")
def test_the_states_above_occur_in_every_await_of_the_firmware(hand):
    seen = set()
    for name in STATES:
        seen |= stack(brought(hand, name).x.task)
    missed = []
    for path in (*FIRMWARE, Path(chip_base.__file__)):
        source = path.read_text("utf-8")
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Await):
                lines = {(str(path), line) for line in range(node.lineno, node.end_lineno + 1)}
                text = source.splitlines()[node.lineno - 1].strip()
                if not lines & seen and text not in NEVER_SUSPENDED:
                    missed.append(f"{path.name}:{node.lineno}: {text}")
    assert missed == []
    assert len(seen) > 40


def events(hand, name, number):
    """Clocks of the next events of a state, far enough ahead for a RESET to be seen exactly then."""
    h = brought(hand, name, *OUTPUTS)
    start, clocks = h.now, []
    while (
        len(clocks) < number and (ps := h.bench.kernel.next_time()) is not None and ps < h.x.clock.ps(start + 30 * STEP)
    ):
        h.bench.run_to(ps)
        if h.now >= start + RESET and h.now not in clocks:
            clocks.append(h.now)
    return [clock - start for clock in clocks]


def story(hand, name, clock, shuffle):
    """RESET is seen so many clocks behind a state; what the chip shows from then on."""
    h = brought(hand, name, *OUTPUTS, shuffle=shuffle)
    start = h.now
    h.put(start + clock - RESET, "reset", 0)
    h.run_to(start + clock)
    first = outputs(h)
    h.run(1000)
    rest(h)
    h.put(h.now, "reset", 1)
    told = (
        first,
        waiting(h),
        h.x.position,
        h.x.travel,
        h.x.registers,
        sorted(h.trace, key=str),
        [str(found) for found in h.x.findings],
    )
    recovered(h)
    return told


@pytest.mark.fact("RESET-5", "RESET-3")
@pytest.mark.parametrize("seeds", few([(1,), (2, 3)], 1))
@pytest.mark.parametrize(
    "name", few([name for name in STATES if name not in ("idle", "live", "half a command", "half a live command")], 14)
)
def test_a_reset_at_the_very_instant_of_another_event_is_the_same_in_any_order(hand, name, seeds):
    for clock in events(hand, name, 3):
        told = story(hand, name, clock, None)
        assert told[0] == HIGH_ALL
        for seed in seeds:
            assert story(hand, name, clock, seed) == told


@pytest.mark.fact("RESET-5", "PIN-4")
@pytest.mark.parametrize("clock", [5 * STEP - 1, 5 * STEP, 5 * STEP + 1, 5 * STEP - HIGH])
def test_a_reset_in_motion_stops_immediately_without_a_ramp(hand, clock):
    h = hand("pulse", "slew", "ready", number=1000, **KNOWN)
    h.send("G")
    h.strobe(h.now, 0x0D, up=h.now + 400)
    h.bench.run_until(lambda: h.x.travel == 1)
    begin = h.now
    h.put(begin + clock - RESET, "reset", 0)
    h.run_to(begin + clock + 100 * STEP)
    begun = 5 + (clock >= 5 * STEP)  # a step that is due at the very instant still begins
    assert h.x.travel == begun
    assert len(h.x.steps()) == begun
    assert h.rises("pulse", begin)[-1] == (clock if clock != 5 * STEP - 1 and clock >= 5 * STEP else 5 * STEP - HIGH)
    assert h.rises("slew", begin) == [clock]
    assert outputs(h) == HIGH_ALL


# ------------------------------------------------------------------------------------------------------------- RESET


@pytest.mark.fact("RESET-2", "UND-RESET-SHORT", "CON-DEFAULT-XTAL", "PIN-4")
@pytest.mark.parametrize("crystal", ["6 MHz", "11 MHz", "3.579545 MHz"])
@pytest.mark.parametrize(("low", "seen"), [(RESET - 1, False), (RESET, True), (RESET + 1, True), (1, False)])
def test_a_reset_of_less_than_15_us_is_not_seen(hand, crystal, low, seen):
    h = hand("programmable_output", crystal=crystal)
    h.send("C\r")
    start = h.now
    h.put(start, "reset", 0)
    h.put(start + low, "reset", None)
    h.run(1000)
    assert h.edges("programmable_output", start) == ([(RESET, 1)] if seen else [])
    assert h.codes == ([] if seen else ["reset-short"])
    if crystal == "6 MHz":
        assert h.x.clock.ps(start + RESET) - h.x.clock.ps(start) == 15_000_000
    h.send("C\r")
    assert h.x.pin("programmable_output").level == 0


@pytest.mark.fact("UND-RESET-SHORT")
def test_short_resets_do_not_add_up(hand):
    h = hand("programmable_output", "ready", number=5, **KNOWN)
    h.send("C\rG")
    h.strobe(h.now, 0x0D, up=h.now + 400)
    for n in range(10):
        h.put(h.now + 5000 + 85 * n, "reset", 0)  # low again when the one before would count
        h.put(h.now + 5000 + 85 * n + 80, "reset", 1)
    h.run(20 * STEP)
    assert h.x.travel == 5
    assert h.x.pin("programmable_output").level == 0
    assert h.codes.count("reset-short") == 10


@pytest.mark.fact("RESET-3", "RESET-4", "CON-OUTPUTS-HIGH", "UND-PARAM-RESET", "UND-PHASE-POWERUP")
def test_a_reset_clears_everything_except_the_parameters(hand):
    h = hand("pulse", number=1, **KNOWN)
    h.send("A 100\rN 7\rS 9\rR 8\rF 6\rZ 5\rE\rA$B\rQV 3\r-\rO 2\rC\rH\r")
    kept = dict(h.x.registers)
    h.put(h.now, "reset", 0)
    h.run(500)
    h.put(h.now, "reset", 1)
    assert outputs(h) == HIGH_ALL
    assert h.x.registers == kept == {"number": 7, "slope": 9, "rate": 8, "firstrate": 6, "divisor": 5, "position": 100}
    assert h.x.program == b""
    h.put(h.now, "io_select", 1)
    assert h.fetch(1) == b"\xff"  # the pointer of V is gone
    h.put(h.now, "io_select", 0)
    h.send("B\r")  # command mode: it acts at once
    h.send("F 40\rR 40\rN 1\rG\r")
    assert h.x.position == 101  # clockwise
    assert h.x.pin("motion_complete").level == 0  # nor is the flag of H left
    assert [h.x.pin(f"phase{n}").level for n in (1, 2, 3, 4)] == [1, 0, 0, 1]  # pattern 1, from pointer 0


@pytest.mark.fact("PIN-4")
def test_while_reset_is_low_nothing_is_taken(hand):
    h = hand("instrobe", "ready")
    h.put(0, "reset", 0)
    h.run_to(1000)
    h.strobe(1000, ord("C"), up=5000)
    h.run_to(9000)
    assert h.trace == []
    h.put(h.now, "reset", 1)
    h.send("C\r")
    low = h.now
    h.put(low, "reset", 0)
    h.strobe(low + 1000, ord("C"), up=low + 1900)
    h.put(low + 1500, "reset", 1)  # the request is there as RESET rises: taken, as at any READY
    h.run(5000)
    assert h.falls("instrobe", low) == [1500 + STROBE]
    h.send("\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == []


def test_the_chip_resets_itself_by_method(hand):
    h = hand("programmable_output")
    h.send("C\r")
    start = h.now
    h.x.reset()
    h.run(121)
    assert h.edges("programmable_output", start) == [(RESET, 1)]
    assert h.x.pin("reset").level == 1
    assert h.codes == []


# ------------------------------------------------------------------------------------------------------------- supply


def cold(hand, *watched, **options):
    h = hand(*watched, cold=True, **options)
    h.bench.run("1 ms")
    return h


def works(h):
    h.send("C\r")
    return h.x.pin("programmable_output").level == 0


@pytest.mark.fact("UND-POWER", "RESET-1")
def test_without_supply_there_is_nothing(hand):
    h = cold(hand, "ready")
    h.put(h.now, "io_request", 0)
    h.x.reset()
    h.run(50_000)
    assert {pin.name: h.x.pin(pin.name).level for pin in SHEET.pins if pin.in_out == "out"} == {
        pin.name: None for pin in SHEET.pins if pin.in_out == "out"
    }
    assert h.trace == []
    assert waiting(h) == "waiting for power"
    with pytest.raises(slewline.Timeout, match="x: waiting for power since 0 ps"):
        h.bench.run_until_idle(timeout="1 ms")


@pytest.mark.fact("RESET-1", "UND-POWER")
@pytest.mark.parametrize(
    ("low_ps", "valid"), [(10 * 10**9, True), (10 * 10**9 - 1, False), (10**9, False), (50 * 10**9, True)]
)
def test_after_power_up_reset_must_be_low_for_10_ms(hand, low_ps, valid):
    h = cold(hand, "ready")
    h.x.pin("reset").drive(0)
    h.x.power(True)
    on = h.bench.now_ps
    assert waiting(h) == "waiting for RESET low for 10 ms"
    assert outputs(h) == HIGH_ALL
    h.x.pin("reset").drive(1, at=on + low_ps)
    h.bench.run_to(on + 10 * 10**9 - 1)
    assert not h.x.idle
    h.bench.run("60 ms")
    assert h.x.idle == valid
    assert h.codes == ([] if valid else ["reset-short"])
    if valid:
        assert works(h)
        return
    h.put(h.now, "io_request", 0)
    h.run(5000)
    assert h.trace == [(h.trace[0][0], "ready", 1)]  # inert
    h.put(h.now, "io_request", 1)
    h.x.reset()  # 15 us at 6 MHz are not enough for a cold chip
    h.bench.run("1 ms")
    assert not h.x.idle
    h.x.pin("reset").pulse(0, "10 ms")
    h.bench.run("11 ms")
    assert works(h)


@pytest.mark.fact("RESET-1", "UND-POWER")
def test_without_a_reset_the_chip_stays_inert(hand):
    h = cold(hand)
    h.x.pin("reset").drive(1)
    h.x.power(True)
    assert waiting(h) == "waiting for RESET low for 10 ms"
    assert h.codes == ["no-power-up-reset"]
    h.bench.run("1 s")
    assert not h.x.idle
    h.x.pin("reset").drive(0)
    h.bench.run("10 ms")
    assert waiting(h) == "waiting for RESET high"
    h.bench.run("10 ms")
    h.x.pin("reset").drive(1)
    assert waiting(h) == "waiting for a command"
    assert works(h)
    h.x.reset()  # from now on a short reset is enough
    h.bench.run("1 ms")
    assert h.x.pin("programmable_output").level == 1
    assert h.codes == ["no-power-up-reset"]


@pytest.mark.fact("RESET-1", "UND-POWER")
@pytest.mark.parametrize("released", [False, True])
def test_an_open_reset_pin_has_its_capacitor(hand, released):
    h = cold(hand)
    if released:
        h.x.pin("reset").drive(1)
        h.x.pin("reset").release()
    h.x.power(True)
    on = h.bench.now_ps
    assert (
        waiting(h)
        == f"waiting for the capacitor at RESET, charged at {slewline.core.time.timebase.readable(on + POWER_UP_RC_PS)}"
    )
    h.bench.run_to(on + POWER_UP_RC_PS - 1)
    assert not h.x.idle
    h.bench.run_to(on + POWER_UP_RC_PS)
    assert h.x.idle
    assert 10 * 10**9 < POWER_UP_RC_PS < 100 * 10**9
    assert works(h)
    assert h.codes == []


@pytest.mark.fact("UND-POWER")
def test_the_capacitor_of_an_earlier_power_up_does_not_count(hand):
    h = cold(hand)
    h.x.power(True)
    h.bench.run("40 ms")
    h.x.power(False)
    h.bench.run("20 ms")
    h.x.power(True)
    on = h.bench.now_ps
    h.bench.run_to(on + POWER_UP_RC_PS - 1)
    assert not h.x.idle
    h.bench.run("1 ns")
    assert h.x.idle


@pytest.mark.fact("UND-POWER")
def test_a_user_who_keeps_reset_low_outlasts_the_capacitor(hand):
    h = cold(hand)
    h.x.power(True)
    on = h.bench.now_ps
    h.x.pin("reset").drive(0, at=on + POWER_UP_RC_PS - 10**9)
    h.bench.run_to(on + POWER_UP_RC_PS + 10**9)
    assert not h.x.idle
    h.x.pin("reset").release()
    assert h.x.idle
    assert works(h)
    assert h.codes == []


@pytest.mark.fact("RESET-1", "UND-POWER")
def test_a_reset_that_was_valid_before_the_supply_failed_does_not_count_afterwards(hand):
    h = hand()
    h.x.pin("reset").drive(0)
    h.bench.run("20 ms")
    h.x.power(False)
    h.bench.run("20 ms")
    h.x.power(True)
    h.bench.run("1 ms")
    h.x.pin("reset").drive(1)
    h.bench.run("1 ms")
    assert not h.x.idle
    assert h.codes == ["reset-short"]


@pytest.mark.fact("UND-PARAM-POWERUP", "RESET-4", "CMD-A-3")
def test_after_power_up_the_registers_hold_what_the_options_say(hand):
    fresh = {"number": 0, "slope": 255, "rate": 3, "firstrate": 3, "divisor": 1, "position": 0xA55A}
    for options in ({}, {"number": 5, "position": 1}, {"slope": 1, "rate": 12, "firstrate": 11, "divisor": 9}):
        h = hand(**options)
        assert h.x.registers == fresh | options
        h.send("A 9\rN 9\rS 9\rR 9\rF 9\rZ 9\rE\rB\rQ")
        h.x.power(False)
        h.bench.run("1 ms")
        h.x.power(True)
        h.bench.run("100 ms")
        assert h.x.registers == fresh | options
        assert h.x.program == b""
        assert h.x.idle
        h.send("G\r")
        assert [code for code in h.codes if code != "no-steps"] == ["uninitialised"] * 5  # once more since power-up


@pytest.mark.fact("UND-PARAM-POWERUP")
def test_each_register_that_nobody_has_set_is_reported_once(hand):
    h = hand()
    h.send("R 10\rF 10\rN 1\rG\rG\rP 42331\r")
    told = [found.text for found in h.x.findings]
    assert told == [
        "G uses the divisor register, which has not been set since power-up; its content is undefined",
        "G uses the slope register, which has not been set since power-up; its content is undefined",
        "P 42331 uses the position register, which has not been set since power-up; its content is undefined",
    ]


@pytest.mark.fact("UND-POWER", "RESET-5")
@pytest.mark.parametrize(
    ("name", "inside"),
    [
        pytest.param(name, inside, marks=[pytest.mark.long] * (number % 2 == inside))
        for number, name in enumerate(STATES)
        for inside in (False, True)
    ],
)
def test_the_supply_may_fail_in_any_state(hand, name, inside):
    h = brought(hand, name, *OUTPUTS)
    start = h.now
    if inside:  # in the first round of an instant
        h.bench.at(h.bench.now_ps + 1, lambda: h.x.power(False))
        h.bench.run_to(h.bench.now_ps + 1)
    else:
        h.x.power(False)
    travel = h.x.travel
    for _ in range(2):
        assert set(outputs(h).values()) == {None}
        assert h.x.pin("clk15").level is None
        assert waiting(h) == "waiting for power"
        assert h.x.travel == travel
        h.run(20 * STEP)
    rest(h)
    assert {level for clock, pin, level in h.trace if pin == "prog" and clock > start} <= {None, 1}
    h.x.power(True)
    h.bench.run("100 ms")
    assert h.x.registers["rate"] == STATES[name][1].get("rate", 3)
    recovered(h)
