"""slewline epics: the motor of a real module, served as an EPICS motor record."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from ...chips import ramps_of, sheet_of
from ...core.messages.whole import counted
from ...core.time.timebase import PS_PER_S, readable
from ...errors import UsageError
from ...links.sockets.address import is_loopback
from ...modules.dialogue import DialogueFile, DialogueHeader
from ...modules.failures import ModuleFailure
from .. import FOUND
from ..live.serve import remark, show_ports
from .module_options import SettingOptions

if TYPE_CHECKING:
    from ...labs.module_motor import ModuleMotor
    from ...labs.record import MotorRecord


@dataclass
class EpicsCommand(SettingOptions):
    """Options of `slewline epics`: the module, its motor and the record to be served."""

    port: str
    part: str
    dialogue: str | None
    parameters: tuple[str, ...]
    record: str
    resolution: float
    units: str
    every: int  # ps
    replace: bool
    allow_remote: bool

    def perform(self) -> int:
        """Serve the record until a signal ends the command; return the exit status."""
        from ...labs.channel_access import interfaces, port_of_server
        from ...labs.record import MotorRecord

        port_of_server()  # is one
        remote = [address for address in interfaces() if not is_loopback(address)]
        if remote and not self.allow_remote:
            raise UsageError(
                f"EPICS_CAS_INTF_ADDR_LIST {' '.join(remote)}: other machines could move the motor; add --allow-remote "
                "if they may, or set the variable to 127.0.0.1"
            )
        every_s = self.every / PS_PER_S
        if not 0.05 <= every_s <= 3600:
            raise click.UsageError(f"--every {readable(self.every)}; allowed 50 ms to 3600 s")
        self.file: DialogueFile | None = None
        try:
            record = MotorRecord(self.record, self.find, self.resolution, self.units, remark)
            self.check_program(record)
            asyncio.run(self.serve(record, every_s))
        except ModuleFailure as failure:
            remark(str(failure))
            return FOUND
        finally:
            if self.file is not None:
                self.file.close()
        return 0

    def find(self) -> ModuleMotor:
        """Find the module, at the start or after communication was lost; return its motor."""
        from ...labs.module_motor import ModuleMotor

        sheet = sheet_of(self.part)
        if not sheet.acting("goto"):
            raise UsageError(f"{self.part} has no serial line; choose a part with one")
        values = self.values()
        found = self.found(self.port, sheet, may_move=True)
        try:
            speech = found.speech
            if self.dialogue is not None and self.file is None:
                header = DialogueHeader(sheet.part, baud=speech.baud, checksum=speech.checked, address=speech.address)
                self.file = DialogueFile(self.dialogue, header, remark)
            if self.file is not None:
                found.transcript = self.file
            motor = ModuleMotor(found, ramps_of(self.part), values, self.crystal_hz)
        except BaseException:
            found.port.close()
            raise
        remark(f"{found.name}, {speech.setting}{', with checksums' * speech.checked}: at {motor.position}")
        return motor

    def values(self) -> Mapping[str, str]:
        """Return the values of the ramp parameters, by parameter name."""
        found: dict[str, str] = {}
        for each in self.parameters:
            name, equals, value = each.partition("=")
            if not (name and equals and value) or name in found:
                raise UsageError(f"{each!r}; expected each parameter of the ramp once, as in S=10")
            found[name] = value
        return found

    def check_program(self, record: MotorRecord) -> None:
        """Refuse a module whose RAM holds a program other than this record's own moves, unless --replace is given."""
        lines = 0 if self.replace else record.motor.foreign_program()
        if lines:
            record.close()
            raise UsageError(
                f"{record.motor.module.name}: its RAM contains a program of {counted(lines, 'line')}, which moves "
                "would replace; save it with slewline pull, then give --replace"
            )

    async def serve(self, record: MotorRecord, every_s: float) -> None:
        """Serve the record until a signal arrives; query the position of a resting motor every `every_s` seconds."""
        from ...labs.channel_access import interfaces, serve
        from ...links.sockets.system import ends

        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        addresses = interfaces()
        for address in addresses:
            if not is_loopback(address):
                remark(f"{address}: open to other machines; any client that connects can move the motor")
        for number in ends():
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(task.cancel) if task is not None else None)
        with suppress(asyncio.CancelledError):
            await serve(record, addresses, lambda port: show_ports([(self.record, f"{addresses[0]}:{port}")]), every_s)
