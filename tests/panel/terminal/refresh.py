"""Write down what the debugger shows now: `python -m tests.panel.terminal.refresh [NAME ...]`.

Read what it changed.
"""

from __future__ import annotations

import sys

from .walks import SNAPSHOTS

if __name__ == "__main__":
    for snapshot in SNAPSHOTS:
        if not sys.argv[1:] or snapshot.name in sys.argv[1:]:
            for size, seen in snapshot.seen().items():
                snapshot.path(size).write_text(seen, "utf-8")
