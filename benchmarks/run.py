"""Every speed figure of the project, measured in one run and printed as one table.

    python benchmarks/run.py [--long] [--page docs/reference/performance.md] [NAME ...]

Figures are ratios to a time measured in the same run, or virtual seconds per second (real time).  Each workload checks
its own result before its figure is accepted.  Computing is timed in CPU seconds, serving by the wall clock.
`--long` adds the runs of a virtual hour.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from datetime import date
from itertools import chain
from pathlib import Path
from random import Random
from typing import Any

import chipset
import compiling
import cy545
import cycles
import growth
import keeping
import motors
import numpy as np
import page
import panel
import parts
import pictures
import profiled
import reading
import serve
import short
import store
import waits
import writing
from asked import judged
from rows import REAL, Measured, Row, best, best_of, by_turns, table
from trees import Workload, reference
from writing import MIX

import slewline
from slewline.chips.cy525 import profile
from slewline.core.motion.train import StepTrain
from slewline.core.time.timebase import Clock

CLOCK = Clock(11_000_000)
ONE_THREAD = os.environ | dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
ONE_THREAD.pop("PYTHONDONTWRITEBYTECODE", None)  # the first run writes the byte code that the others find


def whole() -> None:
    """Run a bench, a chip and its host, the move, and read all of its steps."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x")
    bench.host(chip).send("A 0\rF 3\rR 127\rS 200\rZ 1\rN 65535\rG\r")
    bench.run_until_idle("100 s")
    assert len(chip.steps()) == 65535


def plans() -> list[Row]:
    """Return the rows of a 65,535-step ramped move: planned, and expanded; compared with C for the same runs."""

    def planned() -> StepTrain:
        return StepTrain(CLOCK, 0, profile.move(65535, 3, 127, 200, 1).runs)

    train = planned()
    ticks = train.ends()
    assert len(ticks) == 65535 and train.length == sum(
        i * n for i, n in zip(train.intervals, train.counts, strict=True)
    )
    long = StepTrain(CLOCK, 0, profile.move(65535, 3, 127, 1, 1).runs)
    many = 20

    def expanded(what: Callable[[], object]) -> float:
        return 65535 * many / best(lambda: [what() for _ in range(many)]) / 1e6

    runs, first = len(train.counts), best(planned, 20)
    python = f"Python: {first / runs * 1e6:.2f} µs per run of equal intervals, {runs} runs"
    return [
        Row("move of 65,535 steps: plan", first * 1e3, "ms", 0.5, False, python),
        Row(
            "the same with S = 1: plan",
            best(lambda: StepTrain(CLOCK, 0, profile.move(65535, 3, 127, 1, 1).runs), 20) * 1e3,
            "ms",
            0.5,
            False,
            "the same",
        ),
        Row(
            "move of 65,535 steps: expand to ticks",
            expanded(train.ends),
            "M steps/s",
            100,
            True,
            "np.repeat and np.cumsum over 8 bytes per step",
        ),
        Row(
            "the same: expand to picoseconds",
            expanded(lambda: train.times(1, train.steps)),
            "M steps/s",
            50,
            True,
            "one int64 multiplication and division per step",
        ),
        *beside_c(train, planned),
        Row(
            "position at 1,000,000 instants",
            1 / best(lambda: long.count_many(np.arange(0, 7 * 10**12, 7 * 10**6))),
            "M queries/s",
            5,
            True,
            "np.searchsorted over the runs",
        ),
    ]


def beside_c(train: StepTrain, planned: Callable[[], StepTrain]) -> Iterator[Row]:
    """Yield the rows of a plan, its ticks and a whole bench, compared with ticks from a step generator in C."""
    cases: tuple[tuple[str, Callable[[], object], str], ...] = (
        (
            "expand to ticks",
            train.ends,
            "a long run of equal intervals is filled in place, short runs by np.repeat and np.cumsum",
        ),
        (
            "a first plan",
            planned,
            "computing the runs of equal intervals in Python; the C code receives them ready-made",
        ),
        ("plan and ticks", lambda: planned().ends(), "the same"),
        (
            "a whole bench, from its creation to the arrays of its steps",
            whole,
            profiled.bound("a whole bench", lambda: whole, 1, "per bench"),
        ),
    )
    name, unit = "move of 65,535 steps: {}, compared with a step generator in C", "x C"
    if compiling.COMPILER is None:
        for what, _, bound in cases:
            yield Row(name.format(what), None, unit, None, True, bound, absent=compiling.ABSENT)
        return
    segments = np.array([(i, n, 0) for i, n in zip(train.intervals, train.counts, strict=True)], np.int64)
    made = np.empty(train.steps, np.int64)
    with tempfile.TemporaryDirectory() as folder:
        generate = compiling.step_generator(Path(folder))
        assert generate(segments, made) == train.steps and (made == train.ends()).all()
        for what, ours, bound in cases:
            sides = by_turns(lambda: generate(segments, made), ours, 21)
            yield Row(name.format(what), None, unit, None, True, bound, sides)


def slewing(bench: slewline.Bench) -> tuple[Any, Any]:
    """Return a chip in continuous motion at R = 127."""
    chip = bench.add("cy525", "x")
    host = bench.host(chip)
    host.send("A 0\rF 3\rR 127\rS 200\rZ 1\rN 65000\rH\rG\r")
    bench.run_until(chip.pin("slew").is_(0))
    return chip, host


def endless() -> list[Row]:
    """Return the rows of 10,000,000 continuous steps, undisturbed and disturbed."""
    alone, chip = best_of(lambda: undisturbed)
    assert chip.travel > 9_990_000
    wall, (chip, instants, answers) = best_of(lambda: disturbed, 3)
    assert chip.travel >= 10_000_000, chip.travel
    assert answers == chip.position_at(np.array(instants)).tolist()
    return [
        Row(
            "10,000,000 steps, undisturbed",
            10_000_000 * chip.clock.ps(1137) / 1e12 / alone,
            REAL,
            20_000,
            True,
            "a few events, for any number of steps",
        ),
        Row(
            "10,000,000 steps with 1,000 read-outs, 1,000 rate changes, 100,000 calls of position_at",
            chip.kernel.now / 1e12 / wall,
            REAL,
            500,
            True,
            "the events of each read-out, a ramp plan per rate change, a search per query",
        ),
    ]


def undisturbed() -> Any:
    """Run without disturbance; return the chip."""
    bench = slewline.Bench()
    chip, _ = slewing(bench)
    bench.run_to(chip.clock.ps(10_000_000 * 1137))
    return chip


def disturbed() -> tuple[Any, list[int], list[int]]:
    """Run with a host that reads the position and changes the rate, and with queries of past positions."""
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
    """Return the rows of 10,000 commands through the pins from a host without delays."""

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
    name = "dialogue of 10,000 commands through the pins"
    bound = profiled.bound(name, prepare, 10_000, "per command")
    return [Row(name, chip.kernel.now / 1e12 / wall, REAL, None, True, bound)]


def seconds_of(code: str) -> Measured:
    """Return the user and system seconds of a fresh interpreter, including threads of NumPy."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL, env=ONE_THREAD)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return Measured(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def starting() -> list[Row]:
    """Return the rows of importing slewline, of creating a bench, and of the modules loaded by --help."""
    both = "import numpy", "import slewline; slewline.Bench()"
    sides = [(seconds_of(both[0]), seconds_of(both[1])) for _ in range(10)][1:]  # the first run writes the byte code
    code = (
        "import sys; from slewline.cli.main import main; sys.argv = ['slewline', '--help']\n"
        "try: main()\nexcept SystemExit: pass\nprint('numpy' in sys.modules, file=sys.stderr)"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stderr.strip()
    return [
        Row(
            "import slewline and create a Bench, from bytecode, with NumPy on one thread",
            None,
            "x import numpy",
            1.3,
            False,
            "NumPy is loaded only for the first array",
            sides,
        ),
        Row(
            "slewline --help: NumPy loaded",
            float(loaded != "False"),
            "(0 = no)",
            0,
            False,
            "heavy modules are imported only where they are used",
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
# the high-water mark of this process alone; ru_maxrss would start at the parent's value at the fork
status = dict(line.split(":", 1) for line in open("/proc/self/status") if ":" in line)
print(bench.now_ps / 1e12 / wall, int(status["VmHWM"].split()[0]) / 1024)
"""


def hour() -> list[Row]:
    """Return the rows of an endless run of one virtual hour, in a separate process whose memory can be read."""
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
        Row("the same: speed", ratio, REAL, 20, True, "360,000 read-outs"),
    ]


def exchanging() -> list[Row]:
    """Return the rows of a host in virtual time."""
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}))
    host.ask("F")
    begin = bench.now_ps

    def exchanges() -> None:
        for _ in range(1000):
            host.ask("F")

    wall = best(exchanges, 5)
    virtual = (bench.now_ps - begin) / 6 / 1e12
    name = "1,000 exchanges with a GS-C200S"
    bound = profiled.bound(name, lambda: exchanges, 1000, "per exchange of 4 characters")
    return [Row(name, virtual / wall, REAL, None, True, bound)]


LONG = ("hour", "hours")
JUDGED = (
    "dialogue",
    "exchanging",
    "encoders",
    "packets",
    "scripts",
    "talking",
    "short",
)  # against the reference, by turns
WORKLOADS: dict[str, dict[str, Workload]] = {
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
        "scripts": chipset.scripts,
        "registers": serve.register_rows,
    },
    "CY545": {"plan": cy545.planning, "talking": cy545.talking, "recorded": cy545.recorded},
    "Short work": {"short": short.rows},
    "Parts": {"parts": parts.rows},
    "Motors": {"motors": motors.rows},
    "Panel": {"panel": panel.rows},
    "Tasks that wait": {"waits": waits.rows},
    "Starting and running": {
        "starting": starting,
        "growth": growth.rows,
        "keeping": keeping.rows,
        "hour": hour,
        "hours": keeping.hours,
        "storing": store.rows,
    },
}


def workload(name: str) -> Workload:
    """Return the workload of a name."""
    return next(family[name] for family in WORKLOADS.values() if name in family)


def main() -> int:
    """Run the workloads and print the tables; return the exit status, 1 if a goal is missed."""
    names = list(chain.from_iterable(WORKLOADS.values()))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help=", ".join(names), metavar="NAME")
    parser.add_argument("--long", action="store_true", help="add the runs of a virtual hour")
    parser.add_argument("--page", type=Path, help="write the tables to a page of the docs")
    options = parser.parse_args()
    if not set(options.names) <= set(names):
        parser.error(f"names are {', '.join(names)}")
    if options.page and (options.names or not options.long):
        parser.error("a page needs all workloads: use --long, and no NAME")
    chosen = options.names or [name for name in names if name not in LONG or options.long]
    found: dict[str, list[Row]] = {}
    with reference() as tree:
        for family, workloads in WORKLOADS.items():
            for name, rows in workloads.items():
                if name in chosen:
                    print(f"{name} ...", file=sys.stderr, flush=True)
                    found.setdefault(family, []).extend(judged(rows, tree) if name in JUDGED else rows())
    if options.page:
        options.page.write_text(page.written(found, date.today()), "utf-8")
    for family, lines in found.items():
        print(f"## {family}\n\n{table(lines)}")
    return 0 if all(row.met for lines in found.values() for row in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
