"""Every hook of the house: two hear everything, a third may be removed from inside a call.

A class that tells something has an attribute `on_...`, which is a `Hook`; each has a row here that makes it happen.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.core.time.hook import Hook
from slewline.drive.board.wire import BoardConfig
from slewline.errors import StoreError
from slewline.links.lines.memory_file import FileStore
from tests.drive.pipe import Pipe
from tests.drive.rig import TwinLine, drive_of
from tests.sources import text, tree

SOURCES = Path(slewline.__file__).parent

Told = tuple[Hook, Callable[[], object]]  # the hook, and what makes it tell


def moving() -> tuple[slewline.Bench, slewline.Chip]:
    """A CY525 that is at rest, and whose parameters are set."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", firstrate=9, rate=20, slope=255, number=3)
    bench.host(x, name="host")
    bench.run("1 ms")
    return bench, x


def move(bench: slewline.Bench) -> None:
    bench["host"].send("G\r")
    bench.run_until_idle()


def chip_finding(_path: Path) -> Told:
    bench, x = moving()
    return x.on_finding, lambda: (bench["host"].send("R 200\r"), bench.run_until_idle())


def part_finding(_path: Path) -> Told:
    bench = slewline.Bench()
    modules = [bench.add("gs-c200s", name=name) for name in "xy"]
    port = bench.part("serial_port")
    return port.on_finding, lambda: bench.connect(port, modules)  # they have the same address


def bench_finding(_path: Path) -> Told:
    bench, _ = moving()
    return bench.on_finding, lambda: (bench["host"].send("R 200\r"), bench.run_until_idle())


def power(part: str) -> Callable[[Path], Told]:
    def told(_path: Path) -> Told:
        bench = slewline.Bench()
        x = bench.add(part)
        bench.run("20 ms")
        return x.on_power, lambda: [(x.power(on), bench.run("20 ms")) for on in (False, True)]

    return told


def inputs(_path: Path) -> Told:
    bench, x = moving()
    return bench.kernel.outside.on_input, lambda: (x.pin("wait").pulse(0, "1 ms"), bench.run("2 ms"))


def conflict(_path: Path) -> Told:
    bench, x = moving()
    return x.pin("slew").net.on_conflict, lambda: (x.pin("slew").drive(0), bench.run("1 us"))  # it shows 1


def axis_change(_path: Path) -> Told:
    bench, x = moving()
    return x.axes[0].on_change, lambda: move(bench)


def axis_forget(_path: Path) -> Told:
    bench, x = moving()
    move(bench)
    return x.axes[0].on_forget, lambda: x.axes[0].forget(bench.now_ps)


def motion(name: str) -> Callable[[Path], Told]:
    def told(_path: Path) -> Told:
        bench, x = moving()
        return getattr(x, f"on_motion_{name}"), lambda: move(bench)

    return told


def instruction(_path: Path) -> Told:
    bench, x = moving()
    bench["host"].send("E\rB\rC\r0\rQ")
    bench.run_until_idle()
    return x.on_instruction, lambda: (bench["host"].send("X\r"), bench.run_until_idle())


def command(_path: Path) -> Told:
    bench, x = moving()
    return x.on_command, lambda: move(bench)


def reading(_path: Path) -> Told:
    bench, x = moving()
    return PinEdges(x.pin("abort")).on_change, lambda: (x.pin("abort").pulse(0, "1 us"), bench.run("2 us"))


def event(part: str, line: str) -> Callable[[Path], Told]:
    def told(_path: Path) -> Told:
        bench = slewline.Bench()
        host = bench.host(bench.add(part))
        return host.on_event, lambda: (run_script(bench, host, line), bench.run_until_idle())

    return told


def character(_path: Path) -> Told:
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s"))
    return host.on_character, lambda: host.ask("F")


def journal(path: Path) -> Told:
    bench = slewline.Bench(journal=path / "journal")
    bench.journal.close()
    bench.journal.file = open("/dev/full", "w", buffering=1)  # noqa: SIM115
    return bench.journal.on_failure, lambda: bench.run("1 ms")


def store(path: Path) -> Told:
    memory = FileStore(path / "missing" / "memory")

    def write() -> None:
        with suppress(StoreError):
            memory.write(b"data")

    return memory.on_failure, write


def committed(_path: Path) -> Told:
    bench, _ = moving()
    return bench.kernel.on_commit, lambda: move(bench)


def shaft(name: str) -> Callable[[Path], Told]:
    def told(_path: Path) -> Told:
        bench, x = moving()
        turned = bench.part("motor", to=x).shaft
        turned.stops.append((None, 1))  # and three steps are to come

        def happen() -> None:
            move(bench)
            turned.look(bench.now_ps)

        return getattr(turned, name), happen

    return told


def link(name: str, happen: Callable[[Pipe], object]) -> Callable[[Path], Told]:
    def told(_path: Path) -> Told:
        pipe = Pipe()
        pipe.link.open(BoardConfig(1000))
        pipe.link.reset()
        pipe.run_until(lambda: pipe.link.idle)
        return getattr(pipe.link, name), lambda: (happen(pipe), pipe.run(200_000_000))

    return told


def waking(_path: Path) -> Told:
    bench = slewline.Bench()
    x = bench.add("cy525")
    line = TwinLine()
    drive = drive_of(bench, x, line)
    drive.open()
    drive.run("100 ms")  # it rests

    def happen() -> None:
        for level in (0, 1):
            x.pin("abort").drive(level)
            drive.run("100 ms")

    return drive.on_wake, happen


HOOKS: dict[str, Callable[[Path], Told]] = {
    "on_finding of a chip": chip_finding,
    "on_finding of a part": part_finding,
    "on_finding of a bench": bench_finding,
    **{f"on_power of a {part}": power(part) for part in ("cy525", "gs-c200s", "mc1451a")},
    "on_input": inputs,
    "on_conflict": conflict,
    "on_change of an axis": axis_change,
    "on_forget": axis_forget,
    "on_begin of motions": motion("begin"),
    "on_end of motions": motion("end"),
    "on_instruction": instruction,
    "on_command": command,
    "on_change of a reading": reading,
    "on_event of a host on a bus": event("cy525", "@note here"),
    "on_event of a host on a serial line": event("gs-c200s", "@note here"),
    "on_event of a host that sends packets": event("mc1451a", "@note here"),
    "on_character": character,
    "on_failure of a journal": journal,
    "on_failure of a store": store,
    "on_commit": committed,
    "on_event of a board": link("on_event", lambda pipe: pipe.link.check(3, 256) or pipe.twin.checked(3, True, 10**8)),
    "on_boot": link("on_boot", lambda pipe: pipe.power_up()),
    "on_open": link("on_open", lambda pipe: pipe.link.open(BoardConfig(1000))),
    "on_refused": link("on_refused", lambda pipe: pipe.link.start(0)),
    "on_wake of a drive": waking,
    **{name: shaft(name) for name in ("on_cut", "on_turn", "on_lost")},
}


@pytest.mark.parametrize("name", HOOKS)
def test_two_receive_everything_and_a_third_is_removed_from_inside_a_call(name: str, tmp_path: Path) -> None:
    hook, happen = HOOKS[name](tmp_path)
    before, one, two, gone, once = len(hook.listeners), [], [], [], []

    def first(*told: object) -> None:
        one.append(told)
        if gone.append in hook.listeners:
            hook.remove(gone.append)

    def itself(*told: object) -> None:
        once.append(told)
        hook.remove(itself)

    for listener in (first, gone.append, itself, lambda *told: two.append(told)):
        hook.add(listener)
    happen()
    assert one and one == two
    assert (gone, once) == ([], one[:1])
    assert len(hook.listeners) == before + 2


def test_every_hook_of_the_house_is_listed_here_and_no_attribute_is_a_place_for_one_listener() -> None:
    """An instance attribute `on_...` is a Hook, or the truth of something (on_bus)."""
    hooks = set()
    for path in SOURCES.rglob("*.py"):
        for node in ast.walk(tree(path)) if re.search(r"\bon_\w+\b", text(path)) else ():
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Attribute | ast.Name):
                name = node.target.attr if isinstance(node.target, ast.Attribute) else node.target.id
                if name.startswith("on_"):
                    kind = ast.unparse(node.annotation)
                    assert kind.startswith("Hook["), f"{path.name}: {name} is a {kind}"
                    hooks.add(name)
            if isinstance(node, ast.FunctionDef) and node.name.startswith("on_") and "= Hook()" in ast.unparse(node):
                hooks.add(node.name)  # a property that makes its hook when it is needed
    assert hooks == {name.split()[0] for name in HOOKS}
