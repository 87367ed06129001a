"""The help screen: keys, verbs, and the commands of the selected chip."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Static

from .session import Session
from .verbs import VERBS

KEYS = (
    ("space", "let time pass, let it stand; ends a wait"),
    ("s", "next instruction of the program"),
    ("n", "next step of the motor"),
    ("e", "next edge of a pin, which is asked for"),
    ("f", "next finding"),
    ("b", "breakpoint on the selected row, or no more"),
    ("u", "run to the selected row"),
    ("g", "go to an instant, on or back"),
    ("p", "run to a position"),
    ("left, right", "1 s back, 1 s on; with shift 0.1 s; with ctrl 10 ms"),
    ("[  ]", "time passes slower, faster"),
    ("tab", "next pane; up, down, page up and page down move in it"),
    ("1 to 9, ctrl+w", "select a chip"),
    ("/  :", "command line: a command to the chip, a verb of the debugger"),
    ("d", "dark or light"),
    ("q", "quit"),
)


class HelpScreen(ModalScreen[None]):
    """All there is to know, in one page."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,q,question_mark,enter", "dismiss", show=False),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session

    def compose(self) -> ComposeResult:
        """Make the page."""
        with VerticalScroll(id="help") as scroll:
            scroll.border_title = "help"
            scroll.border_subtitle = "escape closes"
            yield Static(self.text())

    def text(self) -> Content:
        """Return the page."""
        parts: list[tuple[str, str]] = [("Keys\n", "bold $text-primary")]
        parts += [part for key, says in KEYS for part in ((f"  {key:<15}", "bold"), (f" {says}\n", ""))]
        parts.append(("\nVerbs of the debugger\n", "bold $text-primary"))
        for verb in VERBS:
            parts += [(f"  :{verb.name:<9}", "bold"), (f" {verb.takes}{'; ' * bool(verb.takes)}{verb.says}\n", "")]
        sheet = self.session.sheets.get(self.session.selected)
        if sheet is not None:
            parts.append((f"\nCommands of the {sheet['part'].upper()}\n", "bold $text-primary"))
            width = max((len(row["syntax"]) for row in sheet["commands"]), default=0)
            for row in sheet["commands"]:
                parts += [(f"  {row['syntax']:<{width}}", "bold"), (f"  {row['name']}: {row['says']}", "")]
                parts.append((f"  ({row['where']})\n", "dim"))
        return Content.assemble(*parts)
