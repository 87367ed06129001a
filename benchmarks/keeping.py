"""What moves of 50 steps take in memory with `keep="10 s"`, day and night: each case in a process of its own.

The short rows are of some virtual minutes, and say by how much a move makes the process larger once ten seconds are
full; an hour is measured by `--long`.  A bench without any move has 17 MB.
"""

from __future__ import annotations

import subprocess
import sys

from rows import Row

CODE = """
import gc, sys
import slewline
case, seconds = sys.argv[1], float(sys.argv[2])
bench = slewline.Bench(keep="10 s")
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
assert made > 50 * 5 * seconds and not x.findings and x.motor.since >= bench.now_ps - 10 * 10**12
print(of("VmHWM"), (of("VmRSS") - begun[1]) * 2**20 / ((made - begun[0]) / 50), made / 50)
"""
CASES = {
    "CY525": "a host that sends move after move",
    "GS-C200S": "a program in a loop",
    "MC1151A": "a host that sends move after move",
}


def measured(case: str, seconds: int, what: str) -> list[Row]:
    """Megabytes of the process at most, and bytes that a move adds."""
    code = [sys.executable, "-c", CODE, case, str(seconds)]
    most, slope, moves = map(float, subprocess.run(code, capture_output=True, text=True, check=True).stdout.split())
    return [
        Row(f"{case}, {CASES[case]}, keep 10 s, {what}: memory", most, "MB", 40, False,
            f"Python and slewline 17 MB, ten seconds of moves; {moves:,.0f} moves"),
        Row("the same: what a move adds", slope, "B", 20, False, "nothing that is kept; 1.1 to 3.6 kB without keep"),
    ]  # fmt: skip


def rows() -> list[Row]:
    """Two virtual minutes of each case."""
    return [row for case in CASES for row in measured(case, 120, "2 min")]


def hours() -> list[Row]:
    """A virtual hour of each case: some ten minutes of the processor."""
    return [row for case in CASES for row in measured(case, 3600, "1 h")]
