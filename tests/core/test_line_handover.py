"""A sender hands its line over to receivers at rest, and drives it where anything else takes part in the wire."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

import slewline
from slewline import Bench
from slewline.cli.version_line import is_compiled
from slewline.core.time import kernel
from slewline.core.wires import characters
from slewline.core.wires.net import Driver
from slewline.core.wires.waits import edge

pytestmark = pytest.mark.skipif(is_compiled(kernel), reason="compiled callers call the compiled function")

HandedOver = list[tuple[str, bool]]


@pytest.fixture
def handed(monkeypatch: pytest.MonkeyPatch) -> Iterator[HandedOver]:
    """The lines that are sent: the name of the sender, and whether the line was handed over."""
    lines: HandedOver = []
    original = characters.handed_over

    def noted(driver: Driver, line: characters.Characters) -> bool:
        lines.append((driver.name, original(driver, line)))
        return lines[-1][1]

    monkeypatch.setattr(characters, "handed_over", noted)
    yield lines


def dialogue() -> tuple[Bench, Any, Any]:
    """Return a bench, a chip and its host, which have exchanged a line."""
    bench = slewline.Bench()
    chip = bench.add("gs-c200s", "x")
    host = bench.host(chip)
    host.ask("F")
    return bench, chip, host


def test_question_and_answer_are_handed_over_and_leave_the_same_record(handed: HandedOver) -> None:
    bench, chip, host = dialogue()
    handed.clear()
    assert host.ask("V1") == "V+0"
    assert [each for _, each in handed] == [True, True]
    bench.record("x.rxd", "x.txd")
    bench.run("1 ms")
    handed.clear()
    begin = bench.now_ps
    assert host.ask("V1") == "V+0"
    assert [each for _, each in handed] == [True, True]
    wave = characters.Characters(chip.line.frames, host.uart.framed("V1"), begin).wave
    before = (wave.before, *wave.levels)
    edges = [(time, level) for time, level, old in zip(wave.times, wave.levels, before, strict=False) if level != old]
    times, levels = bench.edges("x.rxd", begin)
    assert [*zip(times.tolist(), levels.tolist(), strict=True)] == edges


def test_a_line_is_handed_over_to_all_chips_that_share_it(handed: HandedOver) -> None:
    bench = slewline.Bench()
    chips = [bench.add("gs-c200s", name, address=number) for number, name in ((1, "x"), (2, "y"))]
    host = bench.host(*chips)
    host.ask("F")
    handed.clear()
    assert host.to("y").ask("V1") == "V+0"
    assert handed[0] == (host.uart.driver.name, True)


def waits(bench: Bench, chip: Any, host: Any) -> None:
    """A task that waits for an edge of the wire."""

    async def waiting() -> None:
        await edge(chip.pins["rxd"].net)

    bench.kernel.spawn(waiting, name="waits")
    bench.run("1 us")


def watches(bench: Bench, chip: Any, host: Any) -> None:
    chip.pins["rxd"].net.watch(lambda _net: None)


def samples(bench: Bench, chip: Any, host: Any) -> None:
    chip.pins["rxd"].net.sample(lambda: None)


def drives_too(bench: Bench, chip: Any, host: Any) -> None:
    bench.pin("x.rxd").drive(chip.line.frames.mark)


def another_rate(bench: Bench, chip: Any, host: Any) -> None:
    host.change_line(300, 7, "odd", 2)


@pytest.mark.parametrize("disturb", [waits, watches, samples, drives_too, another_rate])
def test_a_line_is_driven_where_anything_else_takes_part(
    handed: HandedOver, disturb: Callable[[Bench, Any, Any], None]
) -> None:
    bench, chip, host = dialogue()
    disturb(bench, chip, host)
    handed.clear()
    host.send("F\r")
    bench.run("20 ms")
    assert handed[0] == (host.uart.driver.name, False)
    if disturb is not another_rate:
        assert bytes(host.received).endswith(b"R\r")
