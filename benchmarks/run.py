"""Every speed figure of the project, measured in one run and printed as one table.

    python benchmarks/run.py [--long] [--page docs/reference/performance.md] [NAME ...]

Figures are ratios: to real time (virtual seconds per second), to a bare `import numpy`, or to pyvcd in the same run.
Each workload checks its own result before it is believed.  What is computed is timed in seconds of the processor, the
least of some runs; what is served, by the clock.  `--long` adds the runs of a virtual hour.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from random import Random
from typing import Any

import chipset
import cy545
import cycles
import keeping
import motors
import numpy as np
import panel
import parts
import pictures
import reading
import serve
import store
import writing
from rows import Row, best, best_of, table
from writing import MIX

import slewline
from slewline.chips.cy525 import profile
from slewline.core.motion.train import StepTrain
from slewline.core.time.timebase import Clock

CLOCK = Clock(11_000_000)
ONE_THREAD = os.environ | dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
ONE_THREAD.pop("PYTHONDONTWRITEBYTECODE", None)  # the first run writes the byte code that the others find


KLIPPER = 56
KLIPPER_SAYS = "x 56 np.cumsum"


def plans() -> list[Row]:
    """A 65,535-step ramped move: planned, and expanded."""

    def planned() -> StepTrain:
        return StepTrain(CLOCK, 0, profile.move(65535, 3, 127, 200, 1).runs)

    train = planned()
    ticks = train.begin_ticks()
    assert len(ticks) == 65535 and train.length == sum(
        i * n for i, n in zip(train.intervals, train.counts, strict=True)
    )
    long = StepTrain(CLOCK, 0, profile.move(65535, 3, 127, 1, 1).runs)
    many = 20

    def expanded(what: Callable[[], object]) -> float:
        return 65535 * many / best(lambda: [what() for _ in range(many)]) / 1e6

    # Klipper is not here.  On a Zen 5 its C makes steps at a 56th of the rate at which np.cumsum adds up a given array.
    # Other processors add up in memory several times slower, and then these two rows say too much
    given, out = np.full(65535, 1137, np.int64), np.empty(65535, np.int64)
    klipper = KLIPPER * best(lambda: [np.cumsum(given, out=out) for _ in range(many)], 20) / many
    first = best(planned, 20)
    return [
        Row(
            "move of 65,535 steps: plan",
            first * 1e3,
            "ms",
            0.5,
            False,
            "Python: about 0.5 µs a run of equal intervals, 250 runs",
        ),
        Row("the same beside Klipper's rate, a first plan", klipper / first, KLIPPER_SAYS, 10, True, "the same"),
        Row(
            "the same: plan and ticks of all steps",
            klipper / best(lambda: planned().begin_ticks(), 20),
            KLIPPER_SAYS,
            8,
            True,
            "the plan; a long run is filled in place, short ones by np.repeat and np.cumsum",
        ),
        Row(
            "the same with S = 1: plan",
            best(lambda: StepTrain(CLOCK, 0, profile.move(65535, 3, 127, 1, 1).runs), 20) * 1e3,
            "ms",
            0.5,
            False,
            "the same",
        ),
        Row(
            "the same: expand to ticks",
            expanded(train.begin_ticks),
            "M steps/s",
            100,
            True,
            "np.repeat and np.cumsum over 8 bytes a step",
        ),
        Row(
            "the same: expand to picoseconds",
            expanded(train.begins),
            "M steps/s",
            50,
            True,
            "one int64 multiplication and division a step",
        ),
        Row(
            "position of 1,000,000 instants",
            1 / best(lambda: long.begun_many(np.arange(0, 7 * 10**12, 7 * 10**6))),
            "M queries/s",
            5,
            True,
            "np.searchsorted over the runs",
        ),
    ]


def slewing(bench: slewline.Bench) -> tuple[Any, Any]:
    """A chip in continuous motion at R = 127."""
    chip = bench.add("cy525", "x")
    host = bench.host(chip)
    host.send("A 0\rF 3\rR 127\rS 200\rZ 1\rN 65000\rH\rG\r")
    bench.run_until(chip.pin("slew").is_(0))
    return chip, host


def endless() -> list[Row]:
    """10,000,000 continuous steps, undisturbed and disturbed."""
    alone, chip = best_of(lambda: undisturbed)
    assert chip.travel > 9_990_000
    wall, (chip, instants, answers) = best_of(lambda: disturbed, 3)
    assert chip.travel >= 10_000_000, chip.travel
    assert answers == chip.position_at(np.array(instants)).tolist()
    return [
        Row(
            "10,000,000 steps, undisturbed",
            10_000_000 * chip.clock.ps(1137) / 1e12 / alone,
            "x real time",
            20_000,
            True,
            "a handful of events, whatever the number of steps",
        ),
        Row(
            "the same with 1,000 read-outs, 1,000 rate changes, 100,000 position_at",
            chip.kernel.now / 1e12 / wall,
            "x real time",
            500,
            True,
            "about 10 events a read-out, a ramp plan a rate change, 4 µs a question",
        ),
    ]


def undisturbed() -> Any:
    """The run alone."""
    bench = slewline.Bench()
    chip, _ = slewing(bench)
    bench.run_to(chip.clock.ps(10_000_000 * 1137))
    return chip


def disturbed() -> tuple[Any, list[int], list[int]]:
    """A host that reads the position and changes the rate, and questions where the motor was."""
    bench = slewline.Bench()
    chip, host = slewing(bench)
    slice_ps = 10_000_000 * 125_000_000 // 1000
    for number in range(1000):
        bench.run(slice_ps // 2 - 10**8)
        position = host.read_position()
        assert (chip.position - position) % 65536 <= 1
        bench.run(slice_ps // 2 - 10**8)
        host.change_rate((100, 127)[number % 2])
    random = Random(1)
    instants = [random.randrange(bench.now_ps) for _ in range(100_000)]
    return chip, instants, [chip.position_at(instant) for instant in instants]


def dialogue() -> list[Row]:
    """10,000 commands through the pins from a host that never hesitates."""

    def prepare() -> Callable[[], Any]:
        bench = slewline.Bench()
        chip = bench.add("cy525", "x")
        bench.host(chip).send("".join(MIX[n % len(MIX)] + "\r" for n in range(10_000)))

        def run() -> Any:
            bench.run_until_idle("100 s")
            return chip

        return run

    wall, chip = best_of(prepare)
    assert chip.registers["number"] == 300 and not chip.findings
    return [
        Row(
            "dialogue of 10,000 commands through the pins",
            chip.kernel.now / 1e12 / wall,
            "x real time",
            10,
            True,
            "4 instants, 5 resumptions and 6 pin changes a byte, in Python",
        )
    ]


def seconds_of(code: str) -> float:
    """User and system seconds of a fresh interpreter, the least of some runs; threads of NumPy would count as well."""
    times = []
    for _ in range(9):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL, env=ONE_THREAD)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def starting() -> list[Row]:
    """What it costs to import slewline and to make a bench, and what --help loads."""
    numpy, ours = seconds_of("import numpy"), seconds_of("import slewline; slewline.Bench()")
    code = (
        "import sys; from slewline.cli.main import main; sys.argv = ['slewline', '--help']\n"
        "try: main()\nexcept SystemExit: pass\nprint('numpy' in sys.modules, file=sys.stderr)"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stderr.strip()
    return [
        Row(
            "import slewline, make a Bench, both from byte code, NumPy with one thread",
            ours / numpy,
            "x import numpy",
            1.3,
            False,
            "no NumPy is loaded before an array is asked for",
        ),
        Row(
            "slewline --help: NumPy loaded",
            float(loaded != "False"),
            "(0 = no)",
            0,
            False,
            "everything heavy is imported where it is used",
        ),
    ]


HOUR = """
import sys, time
import numpy as np
import slewline
bench = slewline.Bench()
chip = bench.add("cy525", "x")
host = bench.host(chip)
pins = ["x.pulse", "x.slew", "x.outstrobe", "x.motion_complete", "x.io_select", "x.db"]
bench.record(*pins, keep="1 s")
host.send("A 0\\rF 3\\rR 127\\rS 200\\rZ 1\\rN 65000\\rH\\rG\\r")
bench.run_until(chip.pin("slew").is_(0))
begin, count = bench.now_ps, 360_000
start = time.process_time()
for number in range(count):
    if number == count // 2:
        stream = bench.stream_vcd(sys.argv[1], pins)
        stream.__enter__()
    if number == count // 2 + 500:
        stream.__exit__(None, None, None)
    host.read_position()
    bench.run_to(begin + (number + 1) * 10**10)
wall = time.process_time() - start
last = chip.steps(bench.now_ps - 10**12, bench.now_ps)
instants = np.random.default_rng(1).integers(bench.now_ps - 10**12, bench.now_ps, 10_000)
expected = (last.positions[0] - 1 + np.searchsorted(last.times_ps, instants, side="right")) % 65536
assert (chip.position_at(instants) == expected).all()
assert abs(len(last) - 9674) < 3 and len(bench.edges("x.pulse")[0]) > 19_000
# the high-water mark of this process alone; ru_maxrss would begin with what the parent had when it forked
status = dict(line.split(":", 1) for line in open("/proc/self/status") if ":" in line)
print(bench.now_ps / 1e12 / wall, int(status["VmHWM"].split()[0]) / 1024)
"""


def hour() -> list[Row]:
    """An endless run of one virtual hour, in a process of its own so that its memory can be read."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [sys.executable, "-c", HOUR, f"{folder}/window.vcd"], capture_output=True, text=True, check=True
        )
        size = Path(folder, "window.vcd").stat().st_size
    ratio, megabytes = map(float, run.stdout.split())
    return [
        Row(
            "one hour at 9,675 steps/s, a read-out every 10 ms: memory",
            megabytes,
            "MB",
            200,
            False,
            f"the last second is kept; a window of 5 s was streamed ({size / 1e6:.1f} MB of VCD)",
        ),
        Row("the same: speed", ratio, "x real time", 20, True, "360,000 read-outs of 10 events"),
    ]


def exchanging() -> list[Row]:
    """A host in virtual time."""
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}))
    host.ask("F")
    begin = bench.now_ps
    wall = best(lambda: [host.ask("F") for _ in range(1000)], 5)
    virtual = (bench.now_ps - begin) / 6 / 1e12
    bound = "10 instants and 16 resumptions an exchange of 4 characters, in Python"
    return [Row("1,000 exchanges with a GS-C200S", virtual / wall, "x real time", 20, True, bound)]


LONG = ("hour", "hours")
WORKLOADS: dict[str, dict[str, Callable[[], list[Row]]]] = {
    "CY525": {
        "plans": plans,
        "endless": endless,
        "dialogue": dialogue,
        "waveforms": writing.rows,
        "reading": reading.rows,
        "pictures": pictures.pictures,
    },
    "GS-C200S": {"exchanging": exchanging, "serving": serve.module_rows},
    "MC1451A family": {
        "trains": cycles.rows,
        "axes": chipset.axes,
        "encoders": chipset.encoders,
        "packets": chipset.packets,
        "moves": chipset.moves,
        "registers": serve.register_rows,
    },
    "CY545": {"cy545": cy545.rows},
    "Parts": {"parts": parts.rows},
    "Motors": {"motors": motors.rows},
    "Panel": {"panel": panel.rows},
    "To start, and to go on": {
        "starting": starting,
        "keeping": keeping.rows,
        "hour": hour,
        "hours": keeping.hours,
        "storing": store.rows,
    },
}
PAGE = """# Performance

One run of `make bench`, on two cores of an x86-64 server. What is computed is timed in seconds of the processor, the
least of some runs, and nothing is remembered from one run to the next; what is served, by the clock. `python
benchmarks/beside.py reference` shows the ratios to a commit that stays the same.

{}"""


def main() -> int:
    """Run the workloads and print the tables; exit status 1 when a goal is missed."""
    names = list(chain.from_iterable(WORKLOADS.values()))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help=", ".join(names), metavar="NAME")
    parser.add_argument("--long", action="store_true", help="with the runs of a virtual hour")
    parser.add_argument("--page", type=Path, help="write the tables into a page of the docs")
    options = parser.parse_args()
    if not set(options.names) <= set(names):
        parser.error(f"names are {', '.join(names)}")
    chosen = options.names or [name for name in names if name not in LONG or options.long]
    found: dict[str, list[Row]] = {}
    for family, workloads in WORKLOADS.items():
        for name in workloads:
            if name in chosen:
                print(f"{name} ...", file=sys.stderr, flush=True)
                found.setdefault(family, []).extend(workloads[name]())
    text = "\n".join(f"## {family}\n\n{table(rows)}" for family, rows in found.items())
    print(text)
    if options.page:
        options.page.write_text(PAGE.format(text), "utf-8")
    return 0 if all(row.met for rows in found.values() for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
