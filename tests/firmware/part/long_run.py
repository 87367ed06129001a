"""Play many dialogues on the model and the core: python -m tests.firmware.part.long_run --to 100000 --state FILE

It may be stopped at any time; with the same state file it goes on where it was, with the same core and generator only.
The first difference ends it.  PYTHONPATH=build/compiled:. runs the model of `make compiled`, which is a little quicker.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import sys
import tempfile
import time
from pathlib import Path

from . import dialogues, library

SLICE = 20  # dialogues
CORES: dict[int, library.Library] = {}  # of this process


def digest() -> str:
    """Return what stands for the core and for what plays it."""
    files = [
        *sorted(library.CORE.iterdir()),
        *(library.HERE / name for name in ("replay.c", "dialogues.py", "witness.py")),
    ]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]


def part_of(job: tuple[str, int, int]) -> tuple[int, dialogues.Result]:
    """Play dialogues `first` to before `last` with the library at a path; return the first and what they showed."""
    path, first, last = job
    if not CORES:
        CORES[0] = library.Library(Path(path))
    return first, dialogues.run(CORES[0], range(first, last))


def main() -> int:
    """Play dialogues until there are enough; return 1 after a difference."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=int, default=100_000, help="dialogues, seeds 0 and on")
    parser.add_argument("--state", type=Path, required=True, help="where the numbers are kept")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    state = {"core": digest(), "dialogues": 0, "answers": 0, "steps": 0, "edges": 0, "seconds": 0.0, "difference": ""}
    if given.state.exists():
        before = json.loads(given.state.read_text())
        if before.get("core") != state["core"]:
            parser.error(f"{given.state} is of another core, or of other dialogues: {before.get('core')}; begin anew")
        state |= before
    begun, spent = time.monotonic(), state["seconds"]
    with tempfile.TemporaryDirectory() as folder, multiprocessing.Pool(given.processes) as pool:
        path = str(library.build(Path(folder)))
        jobs = [(path, at, min(at + SLICE, given.to)) for at in range(state["dialogues"], given.to, SLICE)]
        for first, found in pool.imap(part_of, jobs):
            state["dialogues"] = min(first + SLICE, given.to)
            state["answers"] += found.answers
            state["steps"] += found.steps
            state["edges"] += found.edges
            state["seconds"] = round(spent + time.monotonic() - begun, 1)
            state["difference"] = found.difference
            given.state.write_text(json.dumps(state) + "\n")
            if first % (50 * SLICE) == 0 or found.difference:
                print(time.strftime("%H:%M:%S"), json.dumps(state), flush=True)
            if found.difference:
                return 1
    print(json.dumps(state))
    return 0


if __name__ == "__main__":
    sys.exit(main())
