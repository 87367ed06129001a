r"""A PyVISA backend: sessions with modules that run in the process of the program that opens them.

    rm = pyvisa.ResourceManager("@slewline")                   # PyVISA finds the package pyvisa_slewline by this name
    rm.list_resources()                                        # ASRLslewline://cy545::INSTR, ...
    rm.open_resource("ASRLslewline://gs-c200s?chs=0::INSTR", read_termination="\r", write_termination="\r")

This is PyVISA-py with one additional kind of session.  Its timeout is in virtual time, like that of a port opened by a
URL: it applies to a whole read, however many characters arrive; the timeout error includes findings of the module, such
as a missing line end.  All other resources are those of PyVISA-py, so the resource of a port that `slewline serve` has
opened also works: TCPIP::127.0.0.1::4001::SOCKET.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..chips import CATALOGUE, sheet_of
from ..errors import SlewlineError
from ..extras import needs
from .rig import NAMED, SCHEME, Rig, seconds, serial_line

try:
    import serial
    from pyvisa import attributes, constants, rname
    from pyvisa.constants import AccessModes, InterfaceType, ResourceAttribute, SerialTermination, StatusCode
    from pyvisa.errors import VisaIOError
    from pyvisa.typing import VISARMSession, VISASession
    from pyvisa.util import LibraryPath
    from pyvisa_py.highlevel import PyVisaLibrary
    from pyvisa_py.serial import SerialSession
except ImportError:
    raise SlewlineError(needs("sessions of PyVISA need", "visa")) from None

SHOWN = 3  # findings, one of each kind, in the error of a timeout
KIND = InterfaceType.asrl, "INSTR"
KEPT = ("asrl_end_in", "asrl_end_out", "send_end_enabled", "termchar", "termchar_enabled", "suppress_end_enabled")


class ModuleTimeout(VisaIOError):
    """A timeout error that includes the findings of the module."""

    def __init__(self, why: str) -> None:
        super().__init__(StatusCode.error_timeout)
        self.why = why
        self.args = (f"{self.args[0]} slewline: {why}",)

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[type, tuple[Any]]:
        return ModuleTimeout, (self.why,)


class ModuleSession(SerialSession):
    """A session with a serial port; its timeout is in virtual time if a slewline module is at the other end."""

    session_type = KIND
    known = 0  # findings up to the last answer
    part = b""  # the incomplete result of a read

    def after_parsing(self) -> None:
        """Open the port by its URL as written: on Windows, PyVISA-py would put COM before every name, even a URL."""
        if "://" not in self.parsed.board:
            super().after_parsing()
            return
        self.interface = serial.serial_for_url(self.parsed.board, timeout=self.timeout, write_timeout=self.timeout)
        if self.rig is not None:
            self.known = len(self.rig.bench.findings)
        for name in KEPT:
            attribute = ResourceAttribute[name]
            self.attrs[attribute] = attributes.AttributesByID[attribute].default

    @property
    def rig(self) -> Rig | None:
        """The rig of the module at the other end; None if the port is a real one."""
        return getattr(self.interface, "rig", None)

    def why(self) -> str:
        """Return why no complete answer has arrived, from the module's findings; empty for a real port."""
        if self.rig is None:
            return ""
        new = {found.code: found.text for found in self.rig.bench.findings[self.known :]}
        texts = [f"{code}: {text}" for code, text in [*new.items()][-SHOWN:]]
        texts += [self.unended()] if self.part else []
        if texts:
            return "; ".join(texts)
        return "; ".join(filter(None, (self.rig.chip.waiting, self.rig.host.uart.far.disagreement)))

    def unended(self) -> str:
        """Return, as text, the characters that an incomplete read received, and any terminator that is missing."""
        if self.get_attribute(ResourceAttribute.asrl_end_in)[0] != SerialTermination.termination_char:
            return f"received {self.part!r}, and nothing more"
        end = bytes([self.get_attribute(ResourceAttribute.termchar)[0]])
        remedy = "set read_termination to the end of the answers"
        return f"received {self.part!r} without {end!r}, the termination character of this session: {remedy}"

    def _read(
        self, reader: Callable[[], bytes], count: int, is_end: Callable[[bytes], bool], suppress_end: bool, *rest: Any
    ) -> tuple[bytes, StatusCode]:
        rig = self.rig
        if rig is None:
            return super()._read(reader, count, is_end, suppress_end, *rest)  # type: ignore[no-any-return]
        over_ps = None if self.timeout is None else rig.present() + seconds(self.timeout)
        data, self.part = bytearray(), b""
        while len(data) < count:
            character = reader()
            data += character
            if character and is_end(character) and not suppress_end:
                self.known = len(rig.bench.findings)
                return bytes(data), StatusCode.success
            if not character or (over_ps is not None and rig.bench.now_ps > over_ps):
                self.part = bytes(data)
                return self.part, StatusCode.error_timeout
        return bytes(data), StatusCode.success_max_count_read


class SlewlineVisaLibrary(PyVisaLibrary):
    """PyVISA-py, extended by sessions with slewline modules."""

    @staticmethod
    def get_library_paths() -> tuple[LibraryPath, ...]:
        """Return a placeholder for the path of the VISA library, since there is no library file."""
        return (LibraryPath(SCHEME),)

    def list_resources(self, session: VISARMSession, query: str = "?*::INSTR") -> tuple[str, ...]:
        """Return the resources that match `query`: existing named modules, and one new module per serial part."""
        urls = [rig.url for rig in NAMED.values()]
        urls += [f"{SCHEME}://{part}" for part in CATALOGUE.ours if serial_line(sheet_of(part)) is not None]
        return tuple(rname.filter([f"ASRL{url}::INSTR" for url in urls], query))

    def handle_return_value(self, session: Any, status_code: int) -> StatusCode:
        """Return the status, or raise the error that it stands for; a timeout error includes the module's findings."""
        one = self.sessions.get(session) if status_code == StatusCode.error_timeout else None
        try:
            return super().handle_return_value(session, status_code)  # type: ignore[no-any-return]
        except VisaIOError:
            if isinstance(one, ModuleSession) and (why := one.why()):
                raise ModuleTimeout(why) from None
            raise

    def open(
        self,
        session: VISARMSession,
        resource_name: str,
        access_mode: AccessModes = AccessModes.no_lock,
        open_timeout: int | None = constants.VI_TMO_IMMEDIATE,
    ) -> tuple[VISASession, StatusCode]:
        """Open a session.

        Raises:
            UsageError: the URL does not denote a module, or has a strap or an option that the part does not have.
        """
        try:
            parsed = rname.parse_resource_name(resource_name)
        except rname.InvalidResourceName:
            parsed = None
        if parsed is None or (parsed.interface_type_const, parsed.resource_class) != KIND:
            return super().open(session, resource_name, access_mode, open_timeout)  # type: ignore[no-any-return]
        return self._register(ModuleSession(session, resource_name, parsed, open_timeout)), StatusCode.success
