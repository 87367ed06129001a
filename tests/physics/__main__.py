"""Print the table: `python -m tests.physics [--quick] [NUMBERS]`; the exit status is 1 if a row is missed."""

from __future__ import annotations

import argparse
import sys

from .rows import ROWS
from .table import report

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.physics", description=__doc__)
    parser.add_argument("numbers", nargs="*", type=int, help="checks to run; without any, all")
    parser.add_argument("--quick", action="store_true", help="leave out the long ones")
    given = parser.parse_args()
    sys.exit(report(ROWS, set(given.numbers), given.quick) > 0)
