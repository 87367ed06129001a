"""Writing of VCD files, compared with pyvcd, which gets the same edges, sorted: of trains, and of a dialogue."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import profiled
from caches import forget
from rows import Row, Sides, timed

import slewline

PINS = ("pulse", "phase1", "phase2", "phase3", "phase4", "slew", "ready", "motion_complete")
MIX = (
    "A 12345", "B", "C", "F 10", "H", "N 300", "O 2", "R 100", "S 200", "T 5", "V 3", "Z 1", "+", "-", "0",
    "N 65535", "R 7", "A 0",
)  # fmt: skip


def running() -> slewline.Bench:
    """Return a chip in continuous motion, 2,000,000 edges on 8 pins."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x")
    bench.record(*(f"x.{pin}" for pin in PINS))
    bench.host(chip).send("A 0\rF 3\rR 127\rS 200\rZ 1\rN 65000\rH\rG\r")
    bench.run_until(lambda: chip.pin("slew").level == 0)
    bench.run_to(chip.clock.ps(500_000 * 1137) + bench.now_ps)
    return bench


def spoken() -> slewline.Bench:
    """Return a host that sends 5,000 commands: bytes on the bus, and two lines of handshake for each."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x")
    bench.record()
    bench.host(chip).send("".join(MIX[n % len(MIX)] + "\r" for n in range(5_000)))
    bench.run_until_idle("100 s")
    return bench


def beside_pyvcd(bench: slewline.Bench, pins: Sequence[str], least: int) -> Sides:
    """Return the seconds in which pyvcd and the bench write the recorded pins, alternately."""
    from vcd import VCDWriter  # the oracle of the tests

    edges = [bench.edges(pin) for pin in pins]
    times = np.concatenate([times for times, _ in edges])
    which = np.repeat(np.arange(len(pins)), [len(times) for times, _ in edges])
    levels = np.concatenate([levels for _, levels in edges])
    order = np.lexsort((which, times))
    values: dict[int, int | str] = {0: 0, 1: 1, -1: "z"}
    shown = [values[level] for level in levels[order].tolist()]
    changes = list(zip((times[order] // 1000).tolist(), which[order].tolist(), shown, strict=True))
    assert len(changes) >= least, len(changes)
    with tempfile.TemporaryDirectory() as folder:

        def with_pyvcd() -> None:
            with Path(folder, "theirs.vcd").open("w") as file, VCDWriter(file, timescale="1 ns", date="") as writer:
                variables = [writer.register_var("x", pin, "wire", size=1, init=1) for pin in pins]
                for at, i, level in changes:
                    writer.change(variables[i], at, level)

        sides = []
        for _ in range(5):
            for old in Path(folder).iterdir():  # to let go of an old file takes as long as a tenth of writing it
                old.unlink()
            theirs = timed(with_pyvcd)[0]
            forget()
            sides.append((theirs, timed(lambda: bench.save_vcd(Path(folder, "ours.vcd")))[0]))
        written = Path(folder, "ours.vcd").read_text().count("\n")
        assert written > len(changes)
    return sides


def saving(name: str, bench: slewline.Bench, items: int, item: str) -> str:
    """Return the bottleneck of writing a file."""
    with tempfile.TemporaryDirectory() as folder:
        return profiled.bound(name, lambda: lambda: bench.save_vcd(Path(folder, "a.vcd")), items, item)


def rows() -> list[Row]:
    """Return the rows of trains, and of a dialogue."""
    moving, dialogue = running(), spoken()
    trains = beside_pyvcd(moving, [f"x.{pin}" for pin in PINS], 2_000_000)
    wires = [*(pin for pin in dialogue.recorded if pin != "x.db"), *(f"x.db{bit}" for bit in range(8))]
    talk = beside_pyvcd(dialogue, wires, 100_000)
    names = "2,000,000 edges of 8 pins to VCD", "dialogue of 5,000 commands, all pins, to VCD"
    bounds = saving(names[0], moving, 2_000_000, "per edge"), saving(names[1], dialogue, 5_000, "per command")
    return [
        Row(names[0], None, "x pyvcd", 8, True,
            f"expanding step trains, merging 8 nets into one, NumPy digit tables: {bounds[0]}", trains),
        Row(names[1], None, "x pyvcd", 3, True,
            f"the states of the commands, then the same work as for the 2,000,000 edges: {bounds[1]}", talk),
    ]  # fmt: skip
