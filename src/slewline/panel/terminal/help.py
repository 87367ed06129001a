"""The help screen: keys, verbs, and the commands of the selected chip."""

from __future__ import annotations

from textwrap import wrap
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Static

from .debugger_verbs import VERBS
from .session import DebugSession
from .text_drawing import Part

TITLE = "bold $text-primary"
NAME = 15  # columns of a key, a verb or a command

KEYS = (
    ("space", "let time run, or pause it; ends a wait"),
    ("s", "next instruction of the program"),
    ("n", "next step of the motor"),
    ("e", "next edge of a pin; type its name"),
    ("f", "next finding"),
    ("b", "set or remove a breakpoint on the selected row"),
    ("u", "run to the selected row"),
    ("g", "go to an instant, forwards or back"),
    ("p", "run to a position"),
    ("left, right", "1 s back, 1 s forwards; with shift 0.1 s, with ctrl 10 ms"),
    ("[  ]", "let time run slower, faster"),
    ("tab", "next pane; up, down, page up, page down scroll it"),
    ("1 to 9, ctrl+w", "select a chip"),
    ("/  :", "command line: to the chip, to the debugger"),
    ("d", "switch between dark and light"),
    ("q", "quit"),
)


class HelpScreen(ModalScreen[None]):
    """The complete help on one page."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,q,question_mark,enter", "dismiss", show=False),
    ]

    def __init__(self, session: DebugSession) -> None:
        super().__init__()
        self.session = session

    def compose(self) -> ComposeResult:
        """Create the widget that shows the page, and its border."""
        with VerticalScroll(id="help") as scroll:
            scroll.border_title = "help"
            scroll.border_subtitle = "escape closes"
            yield Static(self.text())

    def text(self) -> Content:
        """Return the text of the page."""
        width = min(self.app.size.width, 110) - 8
        rows: list[Part] = [("Keys\n", TITLE)]
        rows += [part for key, description in KEYS for part in entry(width, key, description)]
        rows.append(("\nVerbs of the debugger\n", TITLE))
        rows += [
            part
            for verb in VERBS
            for part in entry(width, f":{verb.name}", f"{verb.takes}{'; ' * bool(verb.takes)}{verb.description}")
        ]
        sheet = self.session.sheets.get(self.session.selected)
        if sheet is not None:
            rows.append((f"\nCommands of the {sheet['part'].upper()}\n", TITLE))
            for row in sheet["commands"]:
                rows += entry(width, row["syntax"], f"{row['name']}: {row['says']} ({row['where']})")
        return Content.assemble(*rows)


def entry(width: int, name: str, description: str) -> list[Part]:
    """Return a name, and to the right of it the description, wrapped into rows."""
    first, *more = wrap(description, max(width - NAME - 3, 20)) or [""]
    rows: list[Part] = [(f"  {name:<{NAME}}", "bold"), (f" {first}\n", "")]
    return rows + [(f"{' ' * (NAME + 3)}{row}\n", "") for row in more]
