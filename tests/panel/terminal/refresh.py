"""Write down what the debugger shows now: `python -m tests.panel.terminal.refresh [NAME ...]`.

Read what it changed.
"""

from __future__ import annotations

import sys

from .walks import SIZES, SNAPSHOTS

if __name__ == "__main__":
    for snapshot in SNAPSHOTS:
        if not sys.argv[1:] or snapshot.name in sys.argv[1:]:
            for size in SIZES:
                snapshot.path(size).write_text(snapshot.seen(size), "utf-8")
