"""The events that a client gets after it has subscribed, as rows."""

from __future__ import annotations

from dataclasses import dataclass

from .kinds import TEXT, WHOLE, Data, Key, array
from .rows_of_views import ENTRY

OBJECT: Data = {"type": "object"}


@dataclass(frozen=True)
class EventSpec:
    """An event: a line with `event`, its keys, and `time_ps`."""

    event: str
    says: str
    keys: tuple[Key, ...]

    @property
    def name(self) -> str:
        """What it is called in the schema."""
        return f"{self.event}_event"


EVENTS = (
    EventSpec(
        "view",
        "Something that a panel shows has changed; while time passes, also that alone, ten times a second.",
        (Key("view", OBJECT, "what has changed, in the shape of the reply to `view`; null: it is gone"),),
    ),
    EventSpec(
        "said",
        "Entries are new, or have grown: one that has grown has the number that it had.",
        (Key("entries", array(ENTRY), "as in the reply to `said`"),),
    ),
    EventSpec("stopped", "Time stands, because a breakpoint is met.", (Key("why", TEXT, "which one"),)),
    EventSpec(
        "branch",
        "The server shows another branch, or another instant; a whole view follows.",
        (Key("branch", WHOLE, "its number"),),
    ),
)
