"""The state of a bench as a debugger sees it through a control port, and the debugger's requests.

This module is independent of the screen: `on_change` requests a redraw.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Coroutine
from typing import Any

from ...core.time.hook import Hook
from ...core.time.timebase import PS_PER_S, picoseconds
from ...errors import SlewlineError, UsageError
from ...links.clients.control_client import ControlClient

Data = dict[str, Any]
EVERY = "50 ms"
LIMIT = "3600 s"  # longest step or wait, in virtual time
KEPT = 5000  # stored entries of the conversation
CURVE_PS = 2 * PS_PER_S  # time span of a velocity strip
CURVE_COLUMNS = 240
CURVE_EVERY_S = 0.2
RATES = tuple(float(f"{digit}e{power}") for power in range(-3, 4) for digit in (1, 2, 5))[:-2]  # 0.001 to 1000


class DebugSession:
    """A bench, as its control port reports it."""

    def __init__(self, address: str, token: str | None = None, rate: float = 1.0) -> None:
        self.address, self.token, self.rate = address, token, rate
        self.sheets: dict[str, Data] = {}
        self.listings: dict[str, list[Data]] = {}
        self.entries: dict[int, Data] = {}
        self.parts: Data = {}
        self.breakpoints: list[Data] = []
        self.curves: dict[str, list[float | None]] = {}  # velocity, by the name of the signal
        self.quantities: list[str] = []
        self.selected = ""
        self.why = ""  # reason of the pause
        self.doing = ""  # description of the pending wait
        self.trouble = ""  # last error
        self.last_edge = ""  # pin of the last edge wait
        self.ended = ""
        self.on_change: Hook[[]] = Hook()
        self._programs: dict[str, Any] = {}  # number of the present listing
        self._tasks: set[asyncio.Task[None]] = set()
        self.drawn_ps = -1

    # ------------------------------------------------------------------------------------------------ the connection
    async def open(self) -> None:
        """Connect, and request the complete state."""
        self.client = await ControlClient.connect(self.address, self.token, remote=True)
        self.client.on_event.add(self._event)
        self.client.on_end.add(self._end)
        view = await self.client.subscribe(EVERY)
        self.selected = next(iter(view["chips"]), "")
        for chip in view["chips"]:
            self.sheets[chip] = (await self.client.request("describe", chip=chip))["sheet"]
        self.parts = (await self.client.request("parts"))["parts"]
        self.quantities = (await self.client.request("signals"))["quantities"]
        await self._all_again()
        self._spawn(self._draw_curves())

    async def close(self) -> None:
        """Close the connection."""
        for task in [*self._tasks]:
            task.cancel()
        if hasattr(self, "client"):
            await self.client.close()

    async def _all_again(self) -> None:
        """Request the listings and the conversation again, because the view does not contain them."""
        for chip in self.chips:
            await self._listing(chip)
        reply = await self.client.request("said", start=0)
        self.entries = {entry["number"]: entry for entry in reply["entries"]}
        self.drawn_ps = -1
        self.on_change()

    async def _listing(self, chip: str) -> None:
        self._programs[chip] = self.chips[chip].get("program")
        self.listings[chip] = (await self.client.request("listing", chip=chip))["rows"]
        self.on_change()

    def _event(self, event: Data) -> None:
        kind = event["event"]
        if kind == "view":
            for chip, state in self.chips.items():
                if chip in self._programs and self._programs[chip] != state.get("program"):
                    self._programs[chip] = state.get("program")
                    self._spawn(self._listing(chip))
            if not self.paused:
                self.why = ""
        elif kind == "said":
            self.entries |= {entry["number"]: entry for entry in event["entries"]}
            for number in list(self.entries)[:-KEPT]:
                del self.entries[number]
        elif kind == "stopped":
            self.why = event["why"]
        elif kind == "branch":
            self.why = ""
            self._spawn(self._all_again())
        self.on_change()

    def _end(self, why: str) -> None:
        self.ended = why
        self.on_change()

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        """Run a coroutine in the background, and keep its error, if any, for the screen."""
        task = asyncio.get_running_loop().create_task(self.attempt(work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def attempt(self, work: Coroutine[Any, Any, None]) -> None:
        """Await a coroutine, and keep its error, if any, for the screen."""
        try:
            await work
        except SlewlineError as error:
            self.trouble = str(error)
        self.on_change()

    # ------------------------------------------------------------------------------------------------------ the state
    @property
    def chips(self) -> Data:
        """States of the chips in the view, by chip name."""
        found: Data = self.client.view.get("chips", {})
        return found

    @property
    def pace(self) -> Data:
        """State of virtual time: whether it is paused, the current branch, and further details."""
        found: Data = self.client.view.get("pace", {})
        return found

    @property
    def paused(self) -> bool:
        """True while time is paused."""
        return bool(self.pace.get("paused"))

    @property
    def now_ps(self) -> int:
        """Current instant in ps."""
        return self.client.now_ps

    def chip_state(self, chip: str) -> Data:
        """Return the state of a chip."""
        found: Data = self.chips[chip]
        return found

    def next_chip(self) -> None:
        """Select the next chip."""
        names = list(self.chips)
        self.selected = names[(names.index(self.selected) + 1) % len(names)]
        self.on_change()

    def row_at(self, chip: str) -> int | None:
        """Return the row number of a chip's current instruction in the chip's listing; None if it is not listed."""
        counter = self.chips[chip].get("counter")
        if counter is None:
            return None
        return next((at for at, row in enumerate(self.listings.get(chip, ())) if row["address"] == counter), None)

    def stops_at(self, chip: str, address: int) -> bool:
        """Return whether there is a breakpoint on the instruction at an address of a chip."""
        return {"chip": chip, "address": address} in self.breakpoints

    def pin_names(self) -> list[str]:
        """Return the full names of the pins of all chips and parts."""
        owners = {**self.chips, **self.client.view.get("parts", {})}
        found = {f"{owner}.{pin}" for owner, state in owners.items() for pin in state.get("levels", {})}
        return sorted(found | {f"{part}.{pin}" for part, row in self.parts.items() for pin in row.get("pins", ())})

    def full_pin(self, name: str) -> str:
        """Return the full name of a pin; the name of the selected chip may be left out."""
        return name if "." in name else f"{self.selected}.{name}"

    # ----------------------------------------------------------------------------------------------------------- time
    async def go(self, rate: float | None = None) -> None:
        """Let time run, at the given rate; None: at the present rate."""
        self.rate = self.rate if rate is None else rate
        self.why = ""
        await self.client.request("go", rate=f"{self.rate:g}")

    async def pause(self) -> None:
        """Pause time; abort a pending wait."""
        await self.client.request("pause")

    async def wait_for(self, doing: str, do: str, **keys: Any) -> None:
        """Send the request `do`, which steps or waits, and await its end; `doing` describes the wait to the user.

        Raises:
            UsageError: an earlier wait is still pending, or the server refuses the request.
        """
        if self.doing:
            raise UsageError(f"busy: {self.doing}; press the space bar to end this wait")
        self.doing, self.why, since = doing, "", self.now_ps
        self.on_change()
        try:
            reply = await self.client.request(do, **keys)
            if not reply.get("met", True) and not self.why:
                why = "; ".join(filter(None, (reply.get("why"), f":time {since / PS_PER_S:g} goes back")))
                self.trouble = f"{doing}: not reached within {keys.get('timeout', LIMIT)} of virtual time; {why}"
            self.why = self.why or ("" if self.trouble else doing)
        finally:
            self.doing = ""
            self.on_change()

    async def step(self, by: str) -> None:
        """Run to the selected chip's next "instruction", "step" (of a motor), "command" or "finding"."""
        await self.wait_for(f"next {by}", "step", chip=self.selected, by=by, timeout=LIMIT)

    async def to_edge(self, pin: str, edge: str = "any") -> None:
        """Run to the next edge of a pin: "rises", "falls" or "any"."""
        name = self.full_pin(pin)
        await self.wait_for(f"next edge of {name}", "step", pin=name, edge=edge, timeout=LIMIT)

    async def to_address(self, address: int) -> None:
        """Run until the selected chip is at the instruction with this address."""
        await self._stand()
        where = f"{self.selected} at instruction {address}"
        await self.wait_for(where, "until", chip=self.selected, address=address, timeout=LIMIT)

    async def to_position(self, position: int, axis: int = 1) -> None:
        """Run until an axis of the selected chip is at a position."""
        await self._stand()
        keys = {"chip": self.selected, "position": position, "axis": axis, "timeout": LIMIT}
        await self.wait_for(f"{self.selected} at position {position}", "until", **keys)

    async def to_time(self, ps: int) -> None:
        """Go to an instant, forwards or back."""
        ps = max(ps, 0)
        if ps >= self.now_ps:
            await self._stand()
            await self.wait_for(f"{ps / PS_PER_S:g} s", "until", time=ps)
        else:
            await self.wait_for(f"back to {ps / PS_PER_S:g} s", "back", time=ps)

    async def _stand(self) -> None:
        if not self.paused and not self.doing:
            await self.client.request("pause")

    async def shift(self, seconds: float) -> None:
        """Move forwards in time by `seconds`, or back if `seconds` is negative."""
        await self.to_time(self.now_ps + picoseconds(f"{abs(seconds)} s") * (1 if seconds > 0 else -1))

    async def change_rate(self, by: int) -> None:
        """Raise the rate of time by `by` places in the series 1, 2, 5, 10, or lower it if `by` is negative."""
        near = min(range(len(RATES)), key=lambda at: abs(RATES[at] - self.rate))
        self.rate = RATES[min(max(near + by, 0), len(RATES) - 1)]
        if not self.paused:
            await self.go()
        self.on_change()

    # ---------------------------------------------------------------------------------------------------- breakpoints
    async def toggle(self, point: Data) -> None:
        """Set a breakpoint, or remove it if it is set already."""
        without = [each for each in self.breakpoints if each != point]
        await self.put_breakpoints(without if len(without) < len(self.breakpoints) else [*without, point])

    async def put_breakpoints(self, points: list[Data]) -> None:
        """Replace all breakpoints by the given ones."""
        await self.client.request("breakpoints", breakpoints=points)
        self.breakpoints = points
        self.on_change()

    # ---------------------------------------------------------------------------------------------------------- curves
    async def _draw_curves(self) -> None:
        """Keep the velocity strips up to date with the current instant until the connection ends."""
        while self.client.open:
            if self.now_ps != self.drawn_ps and not self.doing:
                now = self.now_ps
                await self._curves_at(now)
                self.drawn_ps = now
            await asyncio.sleep(CURVE_EVERY_S)

    async def _curves_at(self, now: int) -> None:
        signals = [signal for chip in self.chips for signal in self.velocities(chip)]
        if not signals:
            return
        start = max(now - CURVE_PS, 0)
        try:
            found = await self.client.request("window", signals=signals, start=start, stop=now, columns=CURVE_COLUMNS)
        except UsageError:  # such an early instant is not stored, or there is no such signal
            self.curves = {}
            return
        for signal, curve in found["signals"].items():
            if "values" in curve:
                self.curves[signal] = columns(curve, now - CURVE_PS, now)
        self.on_change()

    def velocities(self, chip: str) -> list[str]:
        """Return the names of a chip's velocity signals, in the order of its axes."""
        return [name for name in self.quantities if re.match(rf"{re.escape(chip)}\W(.*\W)?velocity$", name)]


def columns(curve: Data, start: int, stop: int) -> list[float | None]:
    """Return the curve's value of greatest magnitude in each column of a window; None if it has no value there.

    The window is from `start` to `stop` (ps).
    """
    width = max(stop - start, 1)
    found: list[float | None] = [None] * CURVE_COLUMNS
    times, values = curve["times_ps"], curve["values"]
    for at, (time, value) in enumerate(zip(times, values, strict=True)):
        if value is None:
            continue
        until = times[at + 1] if at + 1 < len(times) else stop
        first = min(max((time - start) * CURVE_COLUMNS // width, 0), CURVE_COLUMNS - 1)
        last = min(max((until - start) * CURVE_COLUMNS // width, first), CURVE_COLUMNS - 1)
        for column in range(first, last + 1):
            found[column] = max(found[column] or 0.0, value, key=abs)
    return found
