"""slewline proxy: relay characters between a host program and its module, and record them."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from ...chips import sheet_of
from ...errors import SlewlineError
from ..live.serve import ended_by_signals, remark, say, show_ports
from .module_options import SettingOptions

if TYPE_CHECKING:
    from ...core.wires.serial import LineSetting
    from ...links.face import OpenPort
    from ...links.sockets.loop import Loop
    from ...modules.dialogue import DialogueFile
    from ...modules.recording_proxy import Proxy, ProxyEnd


@dataclass
class ProxyCommand(SettingOptions):
    """Ports and options of `slewline proxy`."""

    serial: str
    pty: str | None
    tcp: str | None
    part: str
    strap: tuple[tuple[str, int], ...]
    markings: str | None
    dialogue: str
    allow_remote: bool

    def perform(self) -> int:
        """Run the proxy until a signal ends it; return the exit status."""
        from ...links.sockets.system import be_prompt
        from ...modules.recording_proxy import DialogueRecorder, Proxy

        if (self.pty is None) == (self.tcp is None):
            raise click.UsageError("give either --pty LINK or --tcp HOST:PORT, for the host program")
        given = be_prompt()  # same as in the thread of the recorder
        setting, file = self.opened()
        recorder = DialogueRecorder(file)
        try:
            proxy = Proxy(self.serial, setting, recorder, self.host_port, remark, self.echo)
        except SlewlineError:
            recorder.close()
            file.path.unlink(missing_ok=True)  # no character was exchanged
            raise
        with closing(proxy), ended_by_signals(proxy.loop, proxy.stop, lambda: say(report(proxy))):
            show_ports([("host", proxy.port.where)])
            remark(f"{self.serial} at {setting.in_full}; {given}")
            proxy.run()
        say(report(proxy))
        return 0

    def opened(self) -> tuple[LineSetting, DialogueFile]:
        """Return the line settings of the module, and a new dialogue file, open for recording."""
        from ...modules.dialogue import DialogueFile, DialogueHeader
        from ...modules.speech import speech_of

        setting = speech_of(sheet_of(self.part), self.baud, self.checksum, self.address).setting
        header = DialogueHeader(
            self.part,
            self.markings or "",
            self.crystal_hz,
            int(setting.baud),
            self.checksum,
            self.address or 0,
            dict(self.strap),
        )
        return setting, DialogueFile(self.dialogue, header, remark)

    def host_port(self, loop: Loop, line: ProxyEnd) -> OpenPort:
        """Open and return the port for the host program: a pseudo-terminal or a TCP port."""
        if self.pty is not None:
            from ...links.ports.pty import PtyPort

            port = PtyPort(loop, line, self.pty)
            if line.setting.word.bits < 8:
                remark(f"{self.pty}: {port.hint}")
            return port
        from ...links.ports.tcp import TcpPort

        return TcpPort(loop, line, str(self.tcp), self.allow_remote, remark)


def report(proxy: Proxy) -> str:
    """Return a text about the latency of the characters relayed in each direction."""
    return f"slewline: to the module: {proxy.host.lateness}\nslewline: to the host: {proxy.module.lateness}"
