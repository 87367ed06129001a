"""Hosts in asyncio, any number of them at once: each module does what it does when its host is alone, without asyncio.

A host is a list of errands: send something, wait for a position or a level, rest.  The same list is worked by
`bench.run_until` and `bench.run`, and by tasks that wait with `await`, on one bench or on several.
"""

from __future__ import annotations

import asyncio
from random import Random

import pytest

import slewline
from slewline.testing import aio
from tests.ensembles import few

SETUP = "A 0\rF 10\rR 100\rS 240\rZ 1\r"


def errands(chance):
    """What a host does: (verb, argument)."""
    yield "send", SETUP
    position = 0
    for _ in range(chance.randint(1, 5)):
        steps = chance.choice((1, 7, 40, 300))
        yield "rest", f"{chance.choice((1, 50, 1234, 100_000))} us"
        yield "send", f"+\rN {steps}\rG\r"
        position += steps
        if chance.random() < 0.5:
            yield "reach", position - steps + chance.randint(1, steps)
        yield chance.choice((("reach", position), ("idle", None), ("when", position)))
        yield "reach", position


class Module:
    """A chip, its host, and what it notes down."""

    def __init__(self, bench, name):
        self.bench, self.x, self.notes = bench, bench.add("cy525", name=name), []
        self.host = bench.host(self.x, name=f"{name}_host")

    def send(self, text):
        self.host.send(text)

    def conditions(self, verb, argument):
        if verb == "reach":
            return (lambda: True) if self.x.position == argument else self.x.reaches(argument)
        if verb == "when":
            return lambda: self.x.position == argument
        return lambda: self.x.idle and self.host.idle

    def work(self, tasks):
        for verb, argument in tasks:
            if verb == "send":
                self.send(argument)
            elif verb == "rest":
                self.bench.run(argument)
            else:
                self.bench.run_until(self.conditions(verb, argument))
            self.notes.append((verb, self.bench.now_ps, self.x.position))

    async def attend(self, tasks):
        for verb, argument in tasks:
            if verb == "send":
                self.send(argument)
            elif verb == "rest":
                await self.bench.wait(argument)
            else:
                await self.bench.until(self.conditions(verb, argument))
            self.notes.append((verb, self.bench.now_ps, self.x.position))


def agree(seed):
    chance = Random(seed)
    names = [f"m{number}" for number in range(chance.randint(2, 5))]
    programs = {name: list(errands(chance)) for name in names}
    alone = {}
    for name in names:
        alone[name] = Module(slewline.Bench(), name)
        alone[name].work(programs[name])

    async def together():
        shared = slewline.Bench()
        modules = {name: Module(shared if chance.random() < 0.5 else slewline.Bench(), name) for name in names}
        async with asyncio.TaskGroup() as group:
            for module in modules.values():  # all clocks begin together
                await module.bench.wait(0)
            for name, module in modules.items():
                group.create_task(module.attend(programs[name]))
        return modules

    for name, module in aio.run(together()).items():
        assert module.notes == alone[name].notes, (seed, name)
        mine, other = module.x.steps(), alone[name].x.steps()
        assert mine.times_ps[: len(other)].tolist() == other.times_ps.tolist(), (seed, name)


@pytest.mark.parametrize("seed", few(range(5), 2))
def test_running_together_equals_running_alone(seed):
    agree(seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 500))
def test_running_together_equals_running_alone_for_long(seed):
    agree(seed)
