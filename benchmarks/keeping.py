"""Memory of moves of 50 steps, day and night, with `keep="10 s"` and without: each case in its own process.

With `keep`, rows state how much a move enlarges the process once ten seconds are full: the short runs of some virtual
minutes, those of `--long` of an hour.  Without it, they state how much an hour of moves adds, extrapolated from the
growth per move in ten minutes.
"""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

from rows import Row

CODE = """
import gc, sys
import slewline
case, seconds, keep = sys.argv[1], float(sys.argv[2]), sys.argv[3]
bench = slewline.Bench(keep=keep or None)
x = bench.add({"CY525": "cy525", "GS-C200S": "gs-c200s", "MC1151A": "mc1151a"}[case], "x")
host = bench.host(x)

def of(name):
    status = dict(line.split(":", 1) for line in open("/proc/self/status") if ":" in line)
    return int(status[name].split()[0]) / 1024

def cy525():
    host.send("A 0\\rF 10\\rR 100\\rS 240\\rZ 1\\rN 50\\r")
    while True:
        for sign in "+-":
            host.send(f"{sign}\\rG\\r")
            bench.run_until_idle()
            yield

def gs_c200():
    for line in ("Po", "S100", "T1000", "R10", "+50", "-50", "j0", "E"):
        host.ask(line)
    while True:
        bench.run("60 ms")
        yield

def mc1151a():
    host.command("SET_VEL", 1 << 15)
    host.command("SET_ACC", 4096)
    while True:
        for position in (50, 0):
            host.command("SET_POS", position)
            host.command("UPDATE")
            bench.run_until_idle()
            yield

bare = of("VmRSS")
moves = {"CY525": cy525, "GS-C200S": gs_c200, "MC1151A": mc1151a}[case]()
begun = None
for number, _ in enumerate(moves):
    if begun is None and bench.now_ps > seconds * 0.4e12:
        gc.collect()
        begun = x.motor.made, of("VmRSS")
    if bench.now_ps > seconds * 1e12:
        break
gc.collect()
made = x.motor.made
assert made > 50 * 5 * seconds and not x.findings
assert not keep or x.motor.since >= bench.now_ps - 10 * 10**12
added = (of("VmRSS") - begun[1]) * 2**20 / ((made - begun[0]) / 50)
print(of("VmHWM"), added, made / 50, bare)
"""
CASES = {
    "CY525": "a host that sends move after move",
    "GS-C200S": "a program in a loop",
    "MC1151A": "a host that sends move after move",
}
KEEP = "10 s"
AN_HOUR = {"CY525": (94_800, 50), "GS-C200S": (157_600, 90), "MC1151A": (163_000, 280)}  # moves; MB without keep


def ran(case: str, seconds: int, keep: str) -> list[float]:
    """Run a case; return the maximum MB, bytes added per move, moves, and MB before the first."""
    code = [sys.executable, "-c", CODE, case, str(seconds), keep]
    return [*map(float, subprocess.run(code, capture_output=True, text=True, check=True).stdout.split())]


def kept(case: str, seconds: int, what: str) -> list[Row]:
    """Return the rows of the maximum megabytes of the process, and of the bytes that a move adds."""
    most, slope, moves, bare = ran(case, seconds, KEEP)
    bound = (
        f"Python and slewline: {bare:.0f} MB; the rest is the moves of the last ten seconds; {moves:,.0f} moves in all"
    )
    return [
        Row(f"{case}, {CASES[case]}, keep {KEEP}, {what}: memory", most, "MB", 40, False, bound),
        Row(
            "the same: memory added per move", slope, "B", 20, False, "not objects, but freed memory that Python keeps"
        ),
    ]


def unkept(case: str) -> list[Row]:
    """Return the row of the megabytes that an hour of moves adds without `keep`."""
    _, slope, _, _ = ran(case, 600, "")
    moves, goal = AN_HOUR[case]
    name = f"{case}, {CASES[case]}, without keep: an hour of {moves:,} moves adds"
    return [Row(name, slope * moves / 1e6, "MB", goal, False, f"all moves are kept: {slope:,.0f} B per move")]


def rows() -> list[Row]:
    """Return the rows of two virtual minutes of each case."""
    return [row for case in CASES for row in kept(case, 120, "2 min")]


def hours() -> list[Row]:
    """Return the rows of a virtual hour of each case, and of an hour without `keep`, with one process per core."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        long = [pool.submit(kept, case, 3600, "1 h") for case in CASES]
        found = [*long, *(pool.submit(unkept, case) for case in CASES)]
        return [row for job in found for row in job.result()]
