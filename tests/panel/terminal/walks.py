"""Walks through the debugger: keys that are pressed, against a server in a process of its own, and what is seen then.

Time passes by steps and waits alone, so that what is seen does not depend on the clock of the wall.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path

from slewline.cli.live.debug import server_process
from slewline.panel.terminal.debugger import Debugger
from slewline.panel.terminal.session import DebugSession

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "examples"
PAGE = ROOT / "docs/howto/debug.md"
SIZES = {"80x24": (80, 24), "200x50": (200, 50)}
KEYS = {" ": "space", ":": "colon", "/": "slash", ".": "full_stop", "+": "plus", "-": "minus", "_": "underscore"}
LOOK_S = 0.02  # from one look to the next
QUIET = 2  # looks at which the screen is at rest and has not changed: it is drawn beside the keys
LONGEST = 2000  # looks


class Walk:
    """A debugger that is walked through by its keys."""

    def __init__(self, app, pilot):
        self.app, self.pilot, self.session = app, pilot, app.session

    @property
    def screen(self) -> str:
        """What is seen, row by row."""
        rows = self.app.screen._compositor.render_strips()
        return "".join(f"{row.text.rstrip()}\n" for row in rows)

    async def settle(self) -> str:
        """Wait until all is done and drawn; return what is seen."""
        seen, quiet = "", 0
        for _ in range(LONGEST):
            await self.pilot.pause(LOOK_S)
            if not await self.is_at_rest():
                quiet = 0
                continue
            before, seen = seen, self.screen
            quiet = quiet + 1 if seen == before else 0
            if quiet >= QUIET:
                return seen
        raise AssertionError(f"it does not come to rest:\n{seen}")

    async def is_at_rest(self) -> bool:
        """Ask whether nothing is under way, and the screen shows what the server has: however slow either is."""
        session, client = self.session, self.session.client
        drawing = 1  # of the curves, as long as it is connected
        if session.doing or len(session._tasks) > drawing or any(not each.is_finished for each in self.app.workers):
            return False
        if client.view != (await client.request("view"))["view"]:
            return False
        if (await client.request("said", start=max(session.entries, default=-1) + 1))["entries"]:
            return False
        return session.drawn_ps == session.now_ps and not self.app.changed

    async def press(self, *keys: str) -> str:
        """Press keys one after the other, each when the one before has done its work; return what is seen."""
        for key in keys:
            await self.pilot.press(key)
            await self.settle()
        return self.screen

    async def say(self, text: str) -> str:
        """Type a line; return what is seen."""
        await self.pilot.press("slash")
        await self.pilot.press(*(KEYS.get(letter, letter) for letter in text), "enter")
        return await self.settle()

    async def stopped(self, why: str) -> str:
        """Wait until time stands for a reason; return what is seen."""
        for _ in range(LONGEST):
            await self.pilot.pause(LOOK_S)
            if why in self.session.why:
                return await self.settle()
        raise AssertionError(f"it does not stop at {why!r}:\n{self.screen}")


Way = Callable[[Walk], Awaitable[object]]


def walked(arguments: list[str], size: tuple[int, int], way: Way) -> None:
    """Walk a way through the debugger of a program."""

    async def walk() -> None:
        with server_process(arguments) as (address, token):
            app = Debugger(DebugSession(address, token), Path(arguments[0]).name)
            async with app.run_test(size=size) as pilot:
                one = Walk(app, pilot)
                await one.settle()
                await way(one)

    asyncio.run(walk())


# -------------------------------------------------------------------------------------------------------- the snapshots
async def weld(walk: Walk) -> None:
    """The sixth instruction of the program has a breakpoint; from there on, instruction by instruction."""
    await walk.say(":break 6")
    await walk.press("space")
    await walk.stopped("cy525 at instruction 6")
    await walk.press("s", "s", "n", "n", "n")


async def conditional_jump(walk: Walk) -> None:
    """A jump on inputs: stopped there, a step with one input, and back."""
    await walk.say(":break 12")
    await walk.press("space")
    await walk.stopped("at instruction 12")
    await walk.press("s", "s")


async def four_axes(walk: Walk) -> None:
    """Four axes on their way."""
    await walk.say(":time 320 ms")


async def jog(walk: Walk) -> None:
    """A CY545 with a jog switch and a display."""
    await walk.say(":time 500 ms")
    await walk.say(":edge pulse falls")


async def two_chips(walk: Walk) -> None:
    """Two chips that start together, the second one selected."""
    await walk.say(":time 100 ms")
    await walk.press("ctrl+w")


async def help_screen(walk: Walk) -> None:
    """The help."""
    await walk.press("question_mark")


@dataclass(frozen=True)
class Snapshot:
    """A walk, and where it is written down what is seen at its end."""

    name: str
    file: str
    way: Way

    def path(self, size: str) -> Path:
        """The file that shows it."""
        return Path(__file__).parent / f"{self.name}_{size}.txt"

    def seen(self) -> dict[str, str]:
        """Walk, and return what is seen at the end, at each size of the terminal."""
        found = {}

        async def way(walk: Walk) -> None:
            await self.way(walk)
            for name, size in SIZES.items():
                await walk.pilot.resize_terminal(*size)
                found[name] = await walk.settle()

        walked([str(EXAMPLES / self.file)], SIZES["80x24"], way)
        return found


SNAPSHOTS = (
    Snapshot("weld", "programs/weld.cy525", weld),
    Snapshot("conditional_jump", "programs/segments.gs-c200s", conditional_jump),
    Snapshot("four_axes", "mc1451a/four_axes.mc1451a", four_axes),
    Snapshot("jog", "cy545/jog.toml", jog),
    Snapshot("two_chips", "cy545/together.toml", two_chips),
    Snapshot("help", "programs/weld.cy525", help_screen),
)


def on_page() -> str:
    """Return the screen that the page about the debugger shows."""
    rows = SNAPSHOTS[0].path("80x24").read_text("utf-8").splitlines()
    return "\n".join(f"    {row}" for row in rows)
