"""Write down what the debugger shows now: `python -m tests.panel.terminal.refresh [NAME ...]`.

Read what it changed.
"""

from __future__ import annotations

import re
import sys

from .walks import PAGE, SNAPSHOTS, on_page

if __name__ == "__main__":
    for snapshot in SNAPSHOTS:
        if not sys.argv[1:] or snapshot.name in sys.argv[1:]:
            for size, seen in snapshot.seen().items():
                snapshot.path(size).write_text(seen, "utf-8")
    before, screen, behind = re.split(r"((?<=this screen -->\n\n).*?(?=\n\n5\.))", PAGE.read_text("utf-8"), flags=re.S)
    PAGE.write_text(f"{before}{on_page()}{behind}", "utf-8")
