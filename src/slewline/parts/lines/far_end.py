"""The far end of a serial line: the rate, format and addresses there, and whether they suit the near end.

A connector compares the settings of the two ends before it first sends characters with these settings,
and not again while the settings remain the same.  A mismatch is a finding of the connector, even if
other parts are wired between the two ends.
"""

from __future__ import annotations

import re
from typing import Protocol

from ...core.wires.serial import LineSetting, ReceivingEnd, Straps, disagreement, rate_disagreement

RETURN, LF = 0x0D, 0x0A
TELNET = re.compile(rb"(?:\xff[\xfb-\xfe].)+", re.DOTALL)  # offers of and requests for options
NO_LINE = (
    "this port passes characters at any rate, unlike a cable; it does not check whether the program's data bits, "
    "parity and stop bits would work on a cable"
)
CERTAIN = 6  # enough of their bytes to be certain: a single data byte may be 0xff, too
RAW = "the host negotiates options (bytes ff fb to fe), which a module mistakes for commands"
RAW_REMEDY = "this looks like Telnet: use a raw connection, or --rfc2217 with an RFC 2217 client"


class NearEnd(Protocol):
    """The near end of a line, with which the far end is compared."""

    name: str

    @property
    def setting(self) -> LineSetting:
        """Rate and format of the near end."""

    def finding(self, code: str, text: str) -> None:
        """Report a finding of the near end."""


class FarEnd:
    """The receivers at the far end of a line.

    `receivers`: by name, the receivers whose settings are known.
    """

    def __init__(self, near: NearEnd) -> None:
        self.near = near
        self.receivers: dict[str, ReceivingEnd] = {}
        self.compared = False
        self.addressed: dict[str, str] = {}  # names of modules by address, where every module has one
        self.reported: set[str] = set()
        self.begins = True  # a line begins with the next character

    @property
    def disagreement(self) -> str:
        """Text on how the settings of the two ends differ, with the remedy; empty if the settings agree."""
        differing = (
            disagreement(self.near.name, self.near.setting, name, receiver) for name, receiver in self.receivers.items()
        )
        return "; ".join(filter(None, differing))

    def compare(self) -> None:
        """Report each disagreement between the settings of the two ends once; record the address of each module."""
        self.compared = True
        if self._is_new(text := self.disagreement):
            self.near.finding("format", text)
        found = {
            str(receiver.address): name for name, receiver in self.receivers.items() if isinstance(receiver, Straps)
        }
        self.addressed = {} if "0" in found else found

    def opened_at(self, baud: int) -> None:
        """Report, once, that a program opens this port at a rate that is ignored here, but would fail on a cable."""
        differing = (
            rate_disagreement("the program", baud, name, receiver) for name, receiver in self.receivers.items()
        )
        if self._is_new(text := "; ".join(filter(None, differing))):
            self.near.finding("format", f"{text}; {NO_LINE}")

    def look_for_telnet(self, data: bytes) -> None:
        """Report, once, that the host negotiates Telnet options instead of sending characters, if `data` show this."""
        found = TELNET.match(data)
        if found and (self.near.setting.word.bits < 8 or len(found[0]) >= CERTAIN) and self._is_new(RAW):
            self.near.finding("telnet", f"{RAW}; {RAW_REMEDY}")

    def look_at_addresses(self, data: bytes) -> None:
        """Report lines of text that address none of the modules, but only one line for each wrong first character."""
        for byte in data:
            if self.begins and byte not in (RETURN, LF) and chr(byte) not in self.addressed:
                here = ", ".join(f"{address} ({name})" for address, name in sorted(self.addressed.items()))
                text = f"a line begins with {chr(byte)!r}, which is not the address of a module here: no module answers"
                if self._is_new(text):
                    self.near.finding("address", f"{text}; begin the line with {here}, or change the address straps")
            self.begins = byte == RETURN

    def _is_new(self, text: str) -> bool:
        """Return whether a text is not empty and has not been reported before; record it as reported."""
        new = bool(text) and text not in self.reported
        self.reported.add(text)
        return new
