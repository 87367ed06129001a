"""Hashes of dialogues, made by another Python under a hash seed of its own.

python -m tests.laws.digests dialogues 0 10        two hashes a line: the fast path, the twin
"""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path


def digests(dialogues: str, hash_seed: str, first: int, last: int) -> str:
    """What this file prints for the dialogues `first` to `last` - 1 of a module."""
    run = subprocess.run(
        [sys.executable, "-m", __name__, dialogues, str(first), str(last)],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        cwd=Path(__file__).resolve().parents[2],
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout


def main() -> None:
    module = import_module(f".{sys.argv[1]}", __package__)
    for seed in range(int(sys.argv[2]), int(sys.argv[3])):
        dialogue = module.made(seed)
        print(module.play(dialogue).digest(), module.play(dialogue, stepwise=True, shuffle=seed).digest())


if __name__ == "__main__":
    main()
