"""The model of a part at the end of a line, in virtual time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

from ...chips import chip_class
from ...core.datasheet.channel import AdaptiveLine, SerialLine
from ...core.time.hook import Hook
from ...core.time.timebase import PS_PER_S
from ...core.wires.receiver import Character
from ...errors import UsageError
from ...links.lines.connectors import connector
from ...links.lines.framing import FramedLine
from ...links.lines.line_transcript import TranscriptFile
from ...links.lines.pace import Lockstep
from ...parts.hosts.adaptive_host import AdaptiveHost
from ..adapter import FramedSpeech
from ..dialogue import DialogueHeader
from ..spoken import Speech

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.component import Finding
    from ...parts.hosts.bus_host import BusHost
    from ...parts.lines.rs232 import SerialPort

PAUSE_PS = 10**12  # between power-up and the first character


class ModelAdapter:
    """The adapter of a model on a bus: it accepts lines of text, and sends characters at the rate of the line.

    Args:
        speech: the protocol of the part.
    """

    def __init__(self, bench: Bench, chip: Chip, speech: FramedSpeech) -> None:
        self.on_character: Hook[Character] = Hook()
        self.character_ps = round(speech.character_s * PS_PER_S)
        self.kernel = bench.kernel
        host = cast("BusHost", bench.host(chip))
        self.line = FramedLine("adapter", chip, Lockstep(bench), TranscriptFile(bench.kernel), host)
        self.line.attach("dialogue", self._record_sent, lambda: None)
        self.write = self.line.feed

    def _record_sent(self, data: bytes) -> int:
        """Pass each character of the adapter's output to `on_character`; return 0, the number of bytes dropped."""
        for number, byte in enumerate(data):
            over_ps = self.kernel.now + number * self.character_ps
            self.on_character(Character(byte, False, False, over_ps, over_ps))
        return 0


class ModelLine:
    """The model of a part at the end of a line, a second after power-up.

    `received` contains the characters that the model has sent, `found` its findings; both may be cleared.

    Args:
        header: the header of the dialogue, with the part's crystal and straps.
        speech: the protocol of the part.
        options: the options of the model.
        memory: a file with an image of the memory of the chip.
        cls: the class of the chip; None: the class of the part that the header names; a header that gives
            a name of the form module:Class is then refused.
        shown: the bytes of the memory, if there is no file.

    Raises:
        UsageError: the part does not have such straps, crystal or options.
    """

    def __init__(
        self,
        header: DialogueHeader,
        speech: Speech,
        options: Mapping[str, Any] | None = None,
        memory: str | None = None,
        cls: type[Chip] | None = None,
        shown: bytes = b"",
    ) -> None:
        from ...bench import Bench
        from ...bench.memories import put_memory

        bench = Bench()
        straps = strapped(speech) | dict(header.straps)
        cls = cls or chip_class(header.part, allow_code=False)
        self.chip = bench.add(cls, crystal=header.crystal_hz, straps=straps, **(options or {}))
        part = put_memory(bench, self.chip, memory)
        if part is not None and memory is None and shown:
            part.load(shown)
        self.kernel, self.speech = bench.kernel, speech
        self.port: SerialPort | AdaptiveHost | ModelAdapter
        if isinstance(speech, FramedSpeech):
            self.port = ModelAdapter(bench, self.chip, speech)
        elif speech.sheet.channel(AdaptiveLine) is not None:
            over = speech.sheet.through(AdaptiveLine).name
            self.port = cast("AdaptiveHost", bench.host(self.chip, baud=speech.baud, over=over))
            self.port.heed(False)  # a cable of three wires
        else:
            self.port = connector(bench, "line", [self.chip])
        self.received: list[Character] = []
        self.found: list[Finding] = []
        self.port.on_character.add(self.received.append)
        bench.on_finding.add(self.found.append)
        bench.run(PAUSE_PS)

    def run(self, ps: int) -> None:
        """Let time run up to an instant (ps), unless that instant is in the past."""
        self.kernel.run(max(ps, self.kernel.now))

    def wake(self) -> None:
        """Send the characters, if any, that a module needs before its first command, and wait until they are sent."""
        if self.speech.wake:
            self.port.write(self.speech.wake)
            self.run(self.kernel.now + PAUSE_PS)


def strapped(speech: Speech) -> dict[str, int]:
    """Return the strap levels, keyed by pin, for a protocol's rate, address and checksums; empty if no straps."""
    line = speech.sheet.channel(SerialLine)
    if line is None:
        return {}
    levels = next(levels for levels, baud in line.bauds.items() if baud == speech.baud)
    straps = dict(zip(line.baud_pins, levels, strict=True))
    if line.address_pins:
        own = next((levels for levels, address in line.addresses.items() if address == speech.address), None)
        if own is None:
            allowed = ", ".join(map(str, sorted(line.addresses.values())))
            raise UsageError(f"address {speech.address}: the straps cannot set this address; allowed {allowed}")
        straps |= dict(zip(line.address_pins, own, strict=True))
    return straps | ({line.checksum_pin: int(speech.checked)} if line.checksum_pin else {})
