"""The screen of the debugger: chips side by side, their programs, the conversation, and a command line.

It uses only the control port, has no bench of its own, and never blocks while it waits.
"""

from __future__ import annotations

import os
from typing import Any, ClassVar

from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Container, Horizontal
from textual.content import Content
from textual.events import Resize
from textual.widget import Widget
from textual.widgets import Input, Static

from ...core.messages.whole import counted
from ...errors import SlewlineError, UsageError
from .chip_pane import ChipPane
from .command_line import CommandLine
from .debugger_verbs import explained, obey
from .help import HelpScreen
from .panes import Pane, ProgramPane, TalkPane
from .session import DebugSession
from .text_drawing import clock, line

WIDE = 150  # minimum columns for the conversation next to the chips
TALL = 34  # minimum rows for this layout
NARROW = 100  # maximum columns at which the first row has only the program name
OWN = 256  # largest program in a chip's own memory, bytes; external memory may have any content
DRAWN_S = 1 / 15
KEYS = (  # at the foot: key, label, action; the first ones remain on a narrow screen
    ("space", "go", "go"),
    ("s", "instr", "step('instruction')"),
    ("n", "step", "step('step')"),
    ("e", "edge", "ask('edge')"),
    ("b", "break", "break"),
    ("u", "row", "to_row"),
    ("g", "goto", "ask('time')"),
    ("p", "pos", "ask('position')"),
    ("←→", "1 s", "shift(-1.0)"),
    ("?", "help", "help"),
    ("q", "quit", "quit"),
    ("[ ]", "rate", "rate(1)"),
    ("tab", "pane", "app.focus_next"),
    (": /", "command", "line('')"),
    ("f", "finding", "step('finding')"),
    ("⇧←→", "0.1 s", "shift(-0.1)"),
    ("^w", "chip", "next_chip"),
    ("d", "dark/light", "dark"),
)


class Debugger(App[None]):
    """The debugger in the terminal."""

    ENABLE_COMMAND_PALETTE = False
    CSS_PATH = "debugger.tcss"
    TITLE = "slewline debug"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "go", show=False),
        Binding("s", "step('instruction')", show=False),
        Binding("n", "step('step')", show=False),
        Binding("f", "step('finding')", show=False),
        Binding("e", "ask('edge')", show=False),
        Binding("g", "ask('time')", show=False),
        Binding("p", "ask('position')", show=False),
        Binding("b", "break", show=False),
        Binding("u", "to_row", show=False),
        Binding("left", "shift(-1.0)", show=False),
        Binding("right", "shift(1.0)", show=False),
        Binding("shift+left", "shift(-0.1)", show=False),
        Binding("shift+right", "shift(0.1)", show=False),
        Binding("ctrl+left", "shift(-0.01)", show=False),
        Binding("ctrl+right", "shift(0.01)", show=False),
        Binding("left_square_bracket", "rate(-1)", show=False),
        Binding("right_square_bracket", "rate(1)", show=False),
        Binding("colon", "line(':')", show=False),
        Binding("slash", "line('')", show=False),
        Binding("question_mark", "help", show=False),
        Binding("ctrl+w", "next_chip", show=False, priority=True),
        Binding("d", "dark", show=False),
        Binding("q", "quit", show=False),
        *(Binding(str(number), f"chip({number})", show=False) for number in range(1, 10)),
    ]

    def __init__(self, session: DebugSession, name: str) -> None:
        super().__init__()
        self.session, self.named = session, name
        self.changed = True
        self.written: dict[str, str] = {}  # rows by position
        self.failure: SlewlineError | None = None  # reason why the session ended, unless the user ended it

    # ------------------------------------------------------------------------------------------------------ the screen
    def compose(self) -> ComposeResult:
        """Create the widgets that do not depend on the chips; the others are created after connecting."""
        yield Static("", id="title")
        with Container(id="body"):
            yield Container(id="chips")
            yield TalkPane(self.session, id="talk")
        with Horizontal(id="line"):
            yield Static("> ", id="prompt")
            yield CommandLine(self.session, id="command")
        yield Static("", id="keys")

    async def on_mount(self) -> None:
        """Connect to the control port, create the panes of the chips, and redraw changes from now on."""
        self.theme = "textual-light" if light_background() else "textual-dark"
        try:
            await self.session.open()
        except SlewlineError as error:
            self.failure = error
            self.exit()
            return
        places = min(len(self.session.chips), 2)
        chips = self.query_one("#chips")
        for place in range(places):
            with_program = has_program(self.session, place)
            panes: list[Widget] = [ChipPane(self.session, place, classes="chip")]
            if with_program or len(self.session.chips) > 2:
                panes.append(ProgramPane(self.session, place, classes="program"))
            await chips.mount(Container(*panes, classes="view"))
        self.set_class(places == 2, "two")
        self.arrange(self.size.width, self.size.height)
        self.query(Pane).first().focus()
        programs = self.query(ProgramPane)
        if programs:
            programs.first().focus()
        self.session.on_change.add(self.note)
        self.set_interval(DRAWN_S, self.draw)
        self.draw()

    async def on_unmount(self) -> None:
        """Close the connection."""
        await self.session.close()

    def on_resize(self, event: Resize) -> None:
        """Arrange the panes for a new size."""
        self.arrange(event.size.width, event.size.height)

    def arrange(self, width: int, height: int) -> None:
        """Choose the layout for a number of columns and rows: one chip above the conversation, or all side by side."""
        self.set_class(width >= WIDE and height >= TALL, "wide")
        self.note()

    def note(self) -> None:
        """Request a redraw, which takes place at the next call of `draw`."""
        self.changed = True

    def draw(self) -> None:
        """Draw everything that has changed; exit if the connection has ended."""
        if not self.changed or not self.session.chips:
            return
        self.changed = False
        self.draw_title()
        self.draw_foot()
        for pane in self.query(Pane):
            self.name_pane(pane)
            pane.renew()
        if self.session.ended:
            self.failure = UsageError(self.session.ended)
            self.exit()

    def draw_title(self) -> None:
        """Draw the first row: name, reason for the pause (or the pending wait), instant, state, rate, branch."""
        session = self.session
        why = session.why or (f"waiting: {session.doing}" if session.doing else "")
        state = "■ paused " if session.paused and not session.doing else "▶ running"
        width = self.size.width
        left = f" slewline debug  {self.named}" if width >= NARROW else f" {self.named}"
        branch = session.pace.get("branch", 0)
        right = f"  {clock(session.now_ps)}  {state}  rate {session.rate:g}{f'  branch {branch}' if branch else ''} "
        room = max(width - len(right) - len(left), 0)
        self.write("#title", Content.assemble((left, "bold"), line(room, f"  {why}"), (right, "bold")))

    def write(self, where: str, text: Content) -> None:
        """Write a text into the row of the widget with the selector `where`, unless the row already has that text."""
        if self.written.get(where) != text.plain:
            self.written[where] = text.plain
            self.query_one(where, Static).update(text)

    def draw_foot(self) -> None:
        """Draw the prompt, and the last row: an error, help on the typed text, or the key labels."""
        session, width = self.session, self.size.width
        typed = self.query_one(CommandLine)
        explains = explained(session, typed.value) if typed.has_focus else ""
        if session.trouble:
            foot = line(width, (f" {session.trouble}", "bold $text-error"))
        else:
            foot = line(width, (f" {explains}", "")) if explains else keys(width)
        self.write("#prompt", Content(prompt(session)))
        self.write("#keys", foot)

    def name_pane(self, pane: Pane) -> None:
        """Set the title of a pane, and show or hide the pane."""
        session = self.session
        if isinstance(pane, ChipPane):
            chosen = "▸ " if pane.chip == session.selected and len(session.chips) > 1 else ""
            pane.entitle(f"{chosen}{pane.chip}  {session.sheets[pane.chip]['part'].upper()}", pane.scale)
            pane.parent.display = pane.place == 0 or self.has_class("wide")  # type: ignore[union-attr]
        elif isinstance(pane, ProgramPane):
            used = len(pane.rows)
            pane.display = bool(used) or (session.sheets[pane.chip].get("buffer_bytes") or 0) <= OWN
            title = f"program of {pane.chip}" if len(session.chips) > 1 else "program"
            room = session.sheets[pane.chip].get("buffer_bytes")
            size = sum(len(row["bytes"].split()) for row in pane.rows) if used else 0
            pane.entitle(title, f"{size} of {room} bytes" if room else "")
        elif isinstance(pane, TalkPane):
            found = session.client.view.get("findings", 0)
            pane.entitle("conversation", counted(found, "finding") if found else "")

    # --------------------------------------------------------------------------------------------------------- the keys
    def perform(self, work: Any) -> None:
        """Run a coroutine of the session that takes time, without blocking the screen."""
        self.session.trouble = ""
        self.run_worker(self.session.attempt(work))

    def action_go(self) -> None:
        """Let time run if it is paused; otherwise pause it."""
        is_paused = self.session.paused and not self.session.doing
        self.perform(self.session.go() if is_paused else self.session.pause())

    def action_step(self, by: str) -> None:
        """Run to the next event of a kind: "instruction", "step" (of the motor) or "finding"."""
        self.perform(self.session.step(by))

    def action_shift(self, seconds: float) -> None:
        """Move forwards in time by a number of seconds, or back if it is negative."""
        self.perform(self.session.shift(seconds))

    def action_rate(self, by: int) -> None:
        """Raise the rate by a number of places in the series of rates; lower it if the number is negative."""
        self.perform(self.session.change_rate(by))

    def action_break(self) -> None:
        """Set a breakpoint on the selected row, or remove the one that is set there."""
        pane = self.program()
        if pane is not None and pane.address is not None:
            self.perform(self.session.toggle({"chip": pane.chip, "address": pane.address}))
        else:
            self.session.trouble = "no program is stored, so there is no row to stop at"
            self.session.on_change()

    def action_to_row(self) -> None:
        """Run to the selected row."""
        pane = self.program()
        if pane is not None and pane.address is not None:
            self.session.selected = pane.chip
            self.perform(self.session.to_address(pane.address))

    def program(self) -> ProgramPane | None:
        """Return the program pane on which keys act: the focused one, else the selected chip's, else None."""
        panes = [pane for pane in self.query(ProgramPane) if pane.display and pane.parent and pane.parent.display]
        focused = [pane for pane in panes if pane.has_focus]
        return next(iter([*focused, *(pane for pane in panes if pane.chip == self.session.selected)]), None)

    def action_ask(self, verb: str) -> None:
        """Start a command line with a debugger verb, after which the user types the value."""
        given = self.session.last_edge if verb == "edge" else ""
        self.action_line(f":{verb} {given}")

    def action_line(self, text: str) -> None:
        """Go to the command line, and replace its text."""
        self.session.trouble = ""
        command = self.query_one(CommandLine)
        command.put(text)
        command.focus()
        self.note()

    def action_next_chip(self) -> None:
        """Select the next chip."""
        self.session.next_chip()

    def action_chip(self, number: int) -> None:
        """Select a chip by its number; 1 is the first."""
        names = list(self.session.chips)
        if number <= len(names):
            self.session.selected = names[number - 1]
            self.note()

    def action_help(self) -> None:
        """Show the help."""
        self.push_screen(HelpScreen(self.session))

    def action_dark(self) -> None:
        """Switch between the dark and the light theme."""
        self.theme = "textual-light" if self.theme == "textual-dark" else "textual-dark"

    # ------------------------------------------------------------------------------------------------- the command line
    def on_input_changed(self, event: Input.Changed) -> None:
        """Update the help on the typed text."""
        if event.value:
            self.session.trouble = ""
        if event.value == "/":  # starts a line, but no command of any chip
            self.query_one(CommandLine).put("")
        self.note()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Execute the typed line."""
        text = event.value.strip()
        command = self.query_one(CommandLine)
        command.keep(text)
        if text.startswith(":"):
            self.leave()
        if text in (":q", ":quit"):
            self.exit()
        elif text.split(" ")[0] in (":help", ":h"):
            self.action_help()
        elif text:
            self.perform(obey(self.session, text))

    def on_command_line_left(self, _event: CommandLine.Left) -> None:
        """Return from the command line to the panes."""
        self.leave()

    def leave(self) -> None:
        """Move the focus from the command line to a pane."""
        pane = self.program() or self.query(Pane).first()
        pane.focus()
        self.note()


def prompt(session: DebugSession) -> str:
    """Return the prompt: the selected chip's name, then < while a program is being entered into it, otherwise >."""
    chip = session.selected
    if not chip:
        return "> "
    levels = session.chip_state(chip)["levels"]
    entry = [pin for pin in session.sheets[chip]["pins"] if pin["role"] == "program_entry"]
    enters = any(levels.get(pin["name"]) == pin.get("active") for pin in entry)
    running = [pin for pin in session.sheets[chip]["pins"] if pin["role"] == "running"]
    runs = any(levels.get(pin["name"]) == pin.get("active") for pin in running)
    return f" {chip}{'<' if enters and not runs else '>'} "


def keys(width: int) -> Content:
    """Return as many key labels as fit into this width."""
    parts: list[tuple[str, str]] = []
    used = 1
    for key, description, action in KEYS:
        cells = len(key) + len(description) + 2
        if used + cells > width:
            break
        used += cells
        click = f"@click=app.{action}"
        parts += [(f" {key}", f"bold $text-accent {click}"), (f" {description}", click)]
    return Content.assemble(*parts)


def has_program(session: DebugSession, place: int) -> bool:
    """Return whether the chip at a place in the order of the chips (0: the first) can store a program."""
    return bool(session.sheets[list(session.chips)[place]].get("buffer_bytes"))


def light_background() -> bool:
    """Return whether the terminal reports a light background, in the environment variable COLORFGBG."""
    colours = os.environ.get("COLORFGBG", "").split(";")
    return len(colours) > 1 and colours[-1] in ("7", "15")
