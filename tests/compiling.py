"""Bytecode of a new checkout, which the workers of pytest-xdist make together.

They collect the same files in the same order, and each would compile all of them at the same time as the others do.
Here each begins elsewhere, and leaves out what another has made meanwhile.  What changes later is compiled as ever.
"""

from __future__ import annotations

import compileall
import importlib.util
import os
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def share(session: pytest.Session) -> None:
    """Compile what has never been compiled: the sources, and the tests with their assertions rewritten."""
    worker = getattr(session.config, "workerinput", None)
    if worker is None or sys.dont_write_bytecode:
        return
    files = [*sorted(HERE.rglob("test_*.py")), *sorted((HERE.parent / "src").rglob("*.py"))]
    begin = len(files) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
    for path in (*files[begin:], *files[:begin]):
        if path.is_relative_to(HERE):
            rewrite(path, session.config)
        elif not os.path.exists(importlib.util.cache_from_source(str(path))):
            compileall.compile_file(path, quiet=2)


def rewrite(path: Path, config: pytest.Config) -> None:
    """Compile a file of tests; pytest has no public name for this, and without it only time is lost."""
    try:
        from _pytest.assertion.rewrite import PYC_TAIL, _rewrite_test, _write_pyc, assertstate_key, get_cache_dir
    except ImportError:
        return
    compiled = get_cache_dir(path) / f"{path.stem}{PYC_TAIL}"
    if not compiled.exists():
        compiled.parent.mkdir(parents=True, exist_ok=True)
        source, code = _rewrite_test(path, config)
        _write_pyc(config.stash[assertstate_key], code, source, compiled)
