"""A motor record that keeps what it posts, of a module in virtual time."""

from __future__ import annotations

import asyncio

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.chips import ramps_of, sheet_of
from slewline.labs.module_motor import ModuleMotor
from slewline.labs.record import MotorRecord
from slewline.modules.finding import find

GSC = {"S": 10, "T": "1000 steps/s", "R": 50}


def motor_at(url, part="gs-c200s", values=GSC):
    return ModuleMotor(find(url, sheet_of(part), may_move=True), ramps_of(part), values)


class Watched(MotorRecord):
    """A record that keeps what it posts, in the order in which clients are told, and what it says."""

    def __init__(self, url="slewline://gs-c200s?chs=0", part="gs-c200s", values=GSC, **more):
        self.told, self.said = [], []
        super().__init__("m1", lambda: motor_at(url, part, values), say=self.said.append, **more)
        for key, field in self.fields.items():
            field.post = self._noted(key, field.post)

    def _noted(self, key, post):
        async def noted(value):
            self.told.append((key, value))
            await post(value)

        return noted

    def get(self, key):
        value = self.fields[key].value
        return value.item() if hasattr(value, "item") else value

    async def moving(self):
        """Wait until the motor moves."""
        while not self.get("MOVN"):
            await asyncio.sleep(0)

    async def put(self, key, value):
        await self.fields[key].write(value)

    @property
    def chip(self):
        return self.motor.module.port.line.chip

    def of(self, *keys):
        return [each for each in self.told if each[0] in keys]
