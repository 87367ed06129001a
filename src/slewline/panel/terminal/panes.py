"""The common base of the three kinds of panes, and two of these kinds: a stored program, and the conversation.

A pane draws only its visible rows, so a program of 64K costs no more than one of ten bytes.
"""

from __future__ import annotations

from typing import Any, ClassVar

from textual import events
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.widget import Widget

from .session import DebugSession
from .text_drawing import Part, line, stamp

MARKS = {"sent": "→", "got": "←", "finding": "!", "command": "·", "event": " "}
STYLES = {"sent": "$text-primary", "got": "$text-accent", "finding": "bold $text-error", "command": "dim"}
WHEEL = 3  # rows
NARROWEST = 20  # columns; fewer are unreadable


class Pane(Widget, can_focus=True):
    """A part of the screen that shows rows of text, and scrolls."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "scroll_rows(-1)", show=False),
        Binding("down", "scroll_rows(1)", show=False),
        Binding("pageup", "scroll_pages(-1)", show=False),
        Binding("pagedown", "scroll_pages(1)", show=False),
        Binding("home", "scroll_rows(-1000000)", show=False),
        Binding("end", "scroll_rows(1000000)", show=False),
    ]

    def __init__(self, session: DebugSession, **names: Any) -> None:
        super().__init__(**names)
        self.session = session
        self.seen = Content()
        self.named = "", ""  # on its border

    def lines(self, width: int, height: int) -> list[Content]:
        """Return the visible rows, `width` columns wide; `height` rows are visible."""
        raise NotImplementedError

    def move(self, rows: int) -> None:
        """Scroll down, or move the selection down, by a number of rows; up if it is negative."""

    def render(self) -> Content:
        """Return the content to draw, and keep it for the comparison in `renew`."""
        self.seen = self.look()
        return self.seen

    def look(self) -> Content:
        """Return the content for the present state and size."""
        width, height = self.content_size
        if width < NARROWEST or not height:
            return Content()
        return Content("\n").join(self.lines(width, height)[:height])

    def renew(self) -> None:
        """Redraw the pane, but only if its content has changed: a remote terminal needs time for every row."""
        seen = self.look()
        if seen.plain != self.seen.plain or seen.spans != self.seen.spans:
            self.refresh()

    def entitle(self, title: str, subtitle: str = "") -> None:
        """Write a title and a subtitle on the border."""
        if (title, subtitle) != self.named:
            self.named = title, subtitle
            self.border_title, self.border_subtitle = title, subtitle

    def on_focus(self) -> None:
        """Show the selection."""
        self.refresh()

    def on_blur(self) -> None:
        """Hide the selection."""
        self.refresh()

    def action_scroll_rows(self, rows: int) -> None:
        """Scroll down, or move the selection down, by a number of rows (up if it is negative), and redraw."""
        self.move(rows)
        self.refresh()

    def action_scroll_pages(self, pages: int) -> None:
        """Scroll down, or move the selection down, by a number of pages (up if it is negative), and redraw."""
        self.action_scroll_rows(pages * max(self.content_size.height - 1, 1))

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Scroll down, or move the selection down."""
        self.action_scroll_rows(WHEEL)
        event.stop()

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Scroll up, or move the selection up."""
        self.action_scroll_rows(-WHEEL)
        event.stop()


class OfChip(Pane):
    """A pane for one chip; the place of the pane determines which chip this is.

    Place 0 shows the selected chip, and place 1 the chip after it.  On a wide screen with at most two chips, place 0
    always shows the first chip, and place 1 the second.
    """

    def __init__(self, session: DebugSession, place: int, **names: Any) -> None:
        super().__init__(session, **names)
        self.place = place

    @property
    def chip(self) -> str:
        """Name of the chip that the pane shows."""
        names = list(self.session.chips)
        if len(names) <= 2:  # axes keep their columns, as on the screen of the manual
            both_seen = self.app.has_class("wide")
            return names[self.place] if both_seen else self.session.selected
        return names[(names.index(self.session.selected) + self.place) % len(names)]

    @property
    def axes(self) -> int:
        """Number of axes of the chip that the pane shows."""
        return len(self.session.chip_state(self.chip)["axes"])


class ProgramPane(OfChip):
    """A stored program: the current instruction, the selected row, breakpoints."""

    def __init__(self, session: DebugSession, place: int, **names: Any) -> None:
        super().__init__(session, place, **names)
        self.row = self.top = 0
        self.followed: object = None  # current instruction when the row was selected

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Rows of the program's listing, one per instruction."""
        return self.session.listings.get(self.chip, [])

    @property
    def address(self) -> int | None:
        """Address of the instruction in the selected row; None if no program is stored."""
        return self.rows[self.row]["address"] if self.row < len(self.rows) else None

    def move(self, rows: int) -> None:
        """Move the selection down by a number of rows; up if it is negative."""
        self.row = min(max(self.row + rows, 0), max(len(self.rows) - 1, 0))

    def on_click(self, event: events.Click) -> None:
        """Select the row under the mouse."""
        self.row = min(max(self.top + event.y - self.gutter.top, 0), max(len(self.rows) - 1, 0))
        self.refresh()

    def lines(self, width: int, height: int) -> list[Content]:
        """Return the rows around the selection, which first moves to the current instruction if that has changed."""
        chip, session = self.chip, self.session
        current = session.row_at(chip)
        if (chip, current, len(self.rows)) != self.followed:
            self.followed = chip, current, len(self.rows)
            if current is not None:
                self.row = current
        self.move(0)
        if not self.top <= self.row < self.top + height:
            self.top = self.row - height // 2
        self.top = max(min(self.top, len(self.rows) - height), 0)
        if not self.rows:
            return [line(width), line(width, ("  no program is stored", "dim"))]
        seen = self.rows[self.top : self.top + height]
        digits = max(len(str(self.rows[-1]["address"])), 2)
        room = max((len(row["bytes"]) for row in self.rows[:200]), default=0)
        return [self.drawn(width, digits, room, at, row, at == current) for at, row in enumerate(seen, self.top)]

    def drawn(self, width: int, digits: int, room: int, at: int, row: dict[str, Any], current: bool) -> Content:
        """Return row `at` of the listing as text, with `digits` columns for the address and `room` for the bytes."""
        stops = self.session.stops_at(self.chip, row["address"])
        chosen = at == self.row and self.has_focus
        style = "bold $text-success" if current else ""
        parts: list[Part] = [
            ("●" if stops else " ", "bold $text-error"),
            ("▶" if current else " ", style),
            (f"{row['address']:>{digits}}  ", style or ("" if chosen else "dim")),
            (f"{row['bytes']:<{room}}  ", style or ("" if chosen else "dim")),
            (row["text"], style),
        ]
        drawn = line(width, *parts)
        return drawn.stylize("on $primary 30% underline") if chosen else drawn


class TalkPane(Pane):
    """The conversation: lines from the host, answers and commands of the chip, and findings."""

    def __init__(self, session: DebugSession, **names: Any) -> None:
        super().__init__(session, **names)
        self.rows_below = 0  # rows below the visible ones

    def move(self, rows: int) -> None:
        """Scroll by a number of entries, back if it is negative; at the end, follow new entries again."""
        self.rows_below = min(max(self.rows_below - rows, 0), max(len(self.session.entries) - 1, 0))

    def lines(self, width: int, height: int) -> list[Content]:
        """Return the rows of the latest entries or, after scrolling back, of earlier ones."""
        entries = list(self.session.entries.values())
        stop = len(entries) - self.rows_below
        found: list[Content] = []
        for entry in reversed(entries[max(stop - height, 0) : stop]):
            found[:0] = self.drawn(width, entry)
            if len(found) >= height:
                break
        return found[-height:]

    def drawn(self, width: int, entry: dict[str, Any]) -> list[Content]:
        """Return an entry as rows: a finding is shown in full, any other entry in one row."""
        kind = entry["kind"]
        style = STYLES.get(kind, "")
        names = [*self.session.chips, "host"]
        who = max(map(len, names), default=4)
        text = f"{entry['code']}: {entry['text']}" if entry.get("code") else entry["text"]
        head = f"{stamp(entry['time_ps']):>11} {entry['who'][:who]:<{who}} "
        room = max(width - len(head) - 2, 10)
        pieces = wrapped(text, room) if kind == "finding" else [text]
        rows = [line(width, (head, "dim"), (f"{MARKS.get(kind, ' ')} ", style), (pieces[0], style))]
        rows += [line(width, " " * (len(head) + 2), (piece, style)) for piece in pieces[1:]]
        return rows


def wrapped(text: str, width: int) -> list[str]:
    """Return a text wrapped into rows of this width."""
    from textwrap import wrap

    return wrap(text, width) or [""]
