"""The execution of the lines of a script, for each kind of channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ...core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, FlowBus, HostPort, SerialLine
from ...core.wires.waits import first_of, level
from ...language import packets
from ...language.dialect import dialect_of, spoken_as
from ...language.text import Letters
from ...parts.hosts.ends.packet_port import USUAL, operations, packet_of
from ...parts.hosts.packet_host import Result
from .script_runner import TAKEN_US, US_PS, Act, Queue, ScriptProtocol, ScriptRunner

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.datasheet.table import Arg, Sheet


class BusProtocol(ScriptProtocol):
    """The rules for a bus: a command is sent when the chip is READY.

    The command is sent as text or in binary, as the chip requires at that time.
    """

    def command(self, body: str) -> Queue:
        """Return a function that queues a command: text or binary, as the chip requires when the command is sent."""

        async def send(runner: ScriptRunner, chip: Chip) -> None:
            port = runner.port(chip)
            await level(port.ready, 1)
            letters = spoken_as(port.sheet, Letters)
            data = (letters.sent if port.mode.level != 0 else letters.sent_binary)(port.sheet, body)
            runner.report(body)
            await port.send(data)

        return sending(send)

    def send(self, data: bytes, act: Act) -> Queue:
        return sending(act)

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send bytes with the handshake."""
        await runner.port(chip).send(data)


class LineProtocol(ScriptProtocol):
    """The rules for a serial line to a module: a command is a line, which the module answers."""

    def command(self, body: str) -> Queue:
        """Return a function that queues a line; the module's answer to it is reported."""
        return asking(body)

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send bytes unchanged, and report the module's answer if they complete a line."""
        if data.endswith(b"\r"):
            runner.report(f"-> {meaning(await answers(runner, chip, data), chip.sheet)}")
        else:
            runner.line_host.send(data)


class PacketProtocol(ScriptProtocol):
    """The rules for packets: a command is a packet, and the host waits for the words that the command returns."""

    def command(self, body: str) -> Queue:
        """Return a function that queues a command as a packet; the words that the command returns are reported."""
        return exchanging(body)

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send a packet, which consists of a command byte and the words that follow it."""
        port = runner.packet_port(chip)
        for part, is_command in operations(data):
            await port.write(part, is_command, USUAL)
        port.note_axis(data[0])
        await port.ready()
        port.note_update(data[0])

    def axis(self, runner: ScriptRunner, chip: Chip) -> int:
        """Return the number of the axis that the host selected last; 1 if it has not selected any."""
        return runner.packet_port(chip).axis or 1


class FlowProtocol(ScriptProtocol):
    """The rules for a bidirectional bus: commands are sent with handshakes, in the form that the mode requires.

    Answers over the same bus are reported.
    """

    def command(self, body: str) -> Queue:
        """Return a function that queues a command; if the command is a query, the answer to it is reported."""

        async def send(runner: ScriptRunner, chip: Chip) -> None:
            port = runner.flow_host.port
            data = port.shadow.sent(body)
            if not (port.control.heeds and body.startswith(port.shadow.dialect.query)):
                runner.report(body)
                await port.send(data)
                return
            answer = await port.ask(data, port.shadow.query(port.name, body))
            runner.report(f"{body} -> {answered(answer)}")

        return self.send(b"", send)

    def send(self, data: bytes, act: Act) -> Queue:
        """Return a function that queues `act`; a directive on the next line waits until the chip has the bytes."""

        async def taken(runner: ScriptRunner, chip: Chip) -> None:
            await first_of(runner.kernel, runner.kernel.now + TAKEN_US * US_PS, (runner.flow_host.port.busy, 1))

        def queue(runner: ScriptRunner) -> None:
            runner.do(act)
            if runner.directed:
                runner.do(taken)

        return queue

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send bytes with handshakes."""
        await runner.flow_host.port.send(data)


class AdaptiveProtocol(ScriptProtocol):
    """The rules for a serial line with a baud rate that the chip detects.

    Each command is a line in the form that the mode requires.  The answer to a query is reported.
    """

    def command(self, body: str) -> Queue:
        """Return a function that queues a line; the answer to a query is reported."""

        async def send(runner: ScriptRunner, chip: Chip) -> None:
            uart = runner.adaptive_host.uart
            if not body.startswith(uart.shadow.dialect.query):
                runner.report(body)
            answer = await uart.exchange(body)
            if body.startswith(uart.shadow.dialect.query):
                runner.report(f"{body} -> {'no answer' if answer is None else answered(answer)}")

        return lambda runner: runner.do(send)

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send characters unchanged."""
        with runner.nested():
            runner.adaptive_host.send(data)


def answered(answer: str | bytes) -> str:
    """Return an answer as text; an answer in bytes is written in hexadecimal."""
    return answer.replace("\r", " ") if isinstance(answer, str) else answer.hex(" ").upper()


SPEECH: Mapping[type[Channel], ScriptProtocol] = {
    BusHandshake: BusProtocol(),
    SerialLine: LineProtocol(),
    HostPort: PacketProtocol(),
    FlowBus: FlowProtocol(),
    AdaptiveLine: AdaptiveProtocol(),
}


def sending(send: Act) -> Queue:
    """Return a function that queues `send`; a directive on the next line waits until the chip has the bytes."""

    def queue(runner: ScriptRunner) -> None:
        runner.do(send)
        if runner.directed:
            runner.do(_taken)

    return queue


async def _taken(runner: ScriptRunner, chip: Chip) -> None:
    """Wait until the chip is READY again, or has been busy for so long that it must be moving or waiting."""
    port = runner.port(chip)
    await first_of(runner.kernel, runner.kernel.now + port.ps(TAKEN_US), (port.ready, 1))


def asking(text: str) -> Queue:
    """Return a function that queues an action, which sends a line to a module and reports the answer."""

    async def ask(runner: ScriptRunner, chip: Chip) -> None:
        runner.report(f"{text} -> {meaning(await answers(runner, chip, text), chip.sheet)}")

    return lambda runner: runner.do(ask)


async def answers(runner: ScriptRunner, chip: Chip, line: str | bytes) -> list[str]:
    """Send a line and return the module's answers."""
    return await runner.line_host.to(chip.name).uart.exchange(line)


def meaning(found: Sequence[str], sheet: Sheet) -> str:
    """Return answers as text; an error code or state is followed by its meaning in the sheet."""
    if not found:
        return "no answer"
    explanation = dialect_of(sheet).meaning_of(found[0])
    return f"{' '.join(found)}{f' ({explanation})' if explanation else ''}"


def exchanging(text: str) -> Queue:
    """Return a function that queues a command as a packet; the words that the command returns are reported."""

    async def exchange(runner: ScriptRunner, chip: Chip) -> None:
        host, port, command = (
            runner.packet_host,
            runner.packet_port(chip),
            packets.command(chip.sheet, text, chip.crystal_hz),
        )
        row = command.row
        found = await port.exchange(packet_of(row, command.values))
        for arg, value in zip(row.reads, packets.values(row.reads, found), strict=True):
            host.results.append(Result(port.axis, row.name, value))
            runner.report(f"{text} -> {returned(chip.sheet, arg, value)}")
        if not found:
            runner.report(f"{text} = {command.values[0]}" if "/" in text else text)

    return lambda runner: runner.do(exchange)


def returned(sheet: Sheet, arg: Arg, value: int) -> str:
    """Return a word from a chipset as text: decimal or, for bit fields, hexadecimal with the names of set bits."""
    dialect = spoken_as(sheet, packets.Packets)
    bits = {"status": dialect.status, "mode": dialect.mode}.get(arg.name, ())
    if arg.unit and not arg.unit.startswith("bits"):
        return str(value)
    names = packets.shown(value, bits)
    return f"0x{value:04X}{f' ({names})' if names else ''}"
