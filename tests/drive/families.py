"""Chips in motion, one of each family: what drives of real motors are tried with."""

from __future__ import annotations

import slewline

GSC = {"straps": {"chs": 0, "br0": 0, "br1": 0, "br2": 0}}
SCRIPTS = {  # what a host sends at the beginning, by name: part, options, text, seconds
    "cy525 top": ("cy525", {}, "A 0\rF 10\rR 127\rS 255\rZ 1\rN 20000\rG\r", 2.6),
    "cy525 long ramp": ("cy525", {}, "A 0\rF 10\rR 120\rS 40\rZ 1\rN 12000\rG\r", 2.8),
    "cy525 five steps": ("cy525", {}, "A 0\rF 100\rR 100\rS 255\rZ 1\rN 5\rG\r", 0.1),
    "cy525 to and fro": (
        "cy525",
        {},
        "A 0\rF 10\rR 100\rS 200\rZ 1\rN 300\rG\r-\rG\r+\rN 1\rG\rG\r-\rN 40\rG\rB\rN 7\rG\rC\rD 20\rG\r",
        1.5,
    ),
    "cy525 program of slow steps": (
        "cy525",
        {},
        "A 0\rF 1\rR 1\rS 255\rZ 1\rN 1\rE\rD 100\rG\rB\rD 100\rG\rC\rJ 0\r0\rQX\r",
        2.5,
    ),
    "gs-c200s to 10 k": ("gs-c200s", GSC, "I3\rPo\rS100\rT1000\rR255\r+8000\rPx\rE\r", 3),
    "gs-c200s moves in a row": (
        "gs-c200s",
        GSC,
        "I3\rPo\rS20\rT200\rR40\r+50\r-50\r+3\rA2\r-3\r+400\rC2\r-1\rPx\rE\r",
        3,
    ),
    "gs-c200s slow": ("gs-c200s", GSC, "I3\rPo\rS1\rT1\rR40\r+12\rPx\rE\r", 1.6),
    "cy545 to 27 k": (
        "cy545",
        {"rate_table": "27k", "fixed_baud": 9600},
        "+\rF 10\rR 255\rS 250\rN 30000\rG\r",
        2,
    ),
    "mc1451a to 45 k": ("mc1451a", {}, "SET_VEL 45000 steps/s\nSET_ACC 200000 steps/s2\nSET_POS 60000\nUPDATE", 2),
    "mc1451a one step a second": ("mc1451a", {}, "SET_PRFL_VEL\nSET_VEL 66\nSET_ACC 66\nUPDATE", 5),
    "mc1451a endless": ("mc1451a", {}, "SET_PRFL_VEL\nSET_VEL 30000 steps/s\nSET_ACC 60000 steps/s2\nUPDATE", 1.5),
}


def furnished(name, **options):
    """A bench with a chip whose host has queued a script: bench, chip, host, seconds."""
    part, more, text, seconds = SCRIPTS[name]
    bench = slewline.Bench(**options)
    x = bench.add(part, name="x", **more)
    host = bench.host(x, over="serial") if part == "cy545" else bench.host(x)
    host.send(text)
    return bench, x, host, seconds
