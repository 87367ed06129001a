"""Reading of VCD files, compared with pyvcd in the same run."""

from __future__ import annotations

import tempfile
from pathlib import Path

from rows import Row, by_turns
from vcd.reader import TokenKind, tokenize  # the oracle of the tests

import slewline

PINS = ("pulse", "phase1", "phase2", "phase3", "phase4", "slew")


def rows() -> list[Row]:
    """Return the rows of 500,000 edges of six pins, written by us, and read by us and by pyvcd with equal results."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x")
    bench.record(*(f"x.{pin}" for pin in PINS))
    bench.host(chip).send("A 0\rF 3\rR 127\rS 200\rZ 1\rN 65000\rH\rG\r")
    bench.run_until(chip.pin("slew").is_(0))
    bench.run_to(bench.now_ps + chip.clock.ps(126_000 * 1137))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.vcd")
        bench.save_vcd(path)
        found = slewline.read_vcd(path)
        count = 0
        for name in found:
            times, levels = bench.edges(name)
            read = found.edges(name)
            assert (times // 1000 * 1000 == read[0]).all() and (levels == read[1]).all()
            count += len(times)
        assert count >= 500_000, count

        def with_pyvcd() -> int:
            with path.open("rb") as file:
                return sum(token.kind is TokenKind.CHANGE_SCALAR for token in tokenize(file))

        assert with_pyvcd() == count + len(PINS)
        sides = by_turns(with_pyvcd, lambda: slewline.read_vcd(path), 3)
    bound = "about 30 NumPy passes over the words of a block; pyvcd returns only tokens, not arrays"
    return [Row(f"reading a VCD file of {count:,} edges", None, "x pyvcd", 10, True, bound, sides)]
