"""Serial port names that stand for modules: a program that opens "/dev/ttyUSB0" or "COM3" finds a module.

    with named_ports({"COM3": module}):
        main()                               # may use serial.Serial("COM3"), serialx.Serial, or serialx in asyncio

    with named_ports({"COM3": module}, usb={"COM3": {"vid": 0x0403, "pid": 0x6001, "serial_number": "A50285BI"}}):
        main()                               # searches the port list for its adapter

The names are assigned for the duration of the block.  The program may have imported the classes of pySerial and
serialx earlier, since these are not replaced; an object of these classes behaves like one for a
slewline:// URL if its port name is one of the assigned names.  All other ports are unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from inspect import getattr_static
from typing import TYPE_CHECKING, Any, NoReturn
from weakref import WeakSet

from ..core.messages.near import hint
from ..core.time.timebase import Time
from ..errors import UnknownName, UsageError
from .rig import SCHEME, HasRig, seconds

if TYPE_CHECKING:
    from .controller import Controller
    from .rig import Rig

MISSING = object()
Usb = Mapping[str, "int | str"]
ELSEWHERE = ("set_buffer_size", "set_low_latency_mode", "set_input_flow_control")  # pySerial's, on some systems
ADAPTER = ("vid", "pid", "serial_number", "manufacturer", "product", "location", "interface")  # as pySerial has them


class Ports(dict[str, "Controller"]):
    """Modules, keyed by the names of their ports."""

    def __missing__(self, name: str) -> NoReturn:
        raise UnknownName(f"no port {name!r}; available: {', '.join(self) or 'none'}{hint(name, self)}")

    def advance(self, time: Time) -> None:
        """Let the same virtual time pass for each of the modules."""
        for module in set(self.values()):
            module.advance(time)

    def sleep(self, duration: float) -> None:
        """Sleep in virtual time, as a replacement for `time.sleep`: monkeypatch.setattr("time.sleep", ports.sleep)."""
        self.advance(seconds(duration))


def plain(name: object) -> str:
    r"""Return a port name in the form used for comparisons: "com3" and "\\\\.\\COM3" become "COM3"."""
    upper = str(name).upper().removeprefix("\\\\.\\")
    return upper if re.fullmatch(r"COM\d+", upper) else str(name)


def check_modules(modules: Mapping[str, Controller]) -> None:
    """Check that modules can be assigned to port names.

    Raises:
        UsageError: a module has no serial line, or is already on a port of this machine.
    """
    for name, module in modules.items():
        if not module.rig.url.startswith(f"{SCHEME}://"):
            raise UsageError(f"{name}: {module.label}; allowed only parts with a serial line, and only with on='url'")


def check_adapters(modules: Mapping[str, Controller], usb: Mapping[str, Usb]) -> None:
    """Check the adapters' entries for the port list.

    Raises:
        UsageError: an entry is for an unknown port, has an unknown key, or has a value that is not allowed.
    """
    for name, adapter in usb.items():
        if name not in modules:
            raise UsageError(f"usb: no port {name!r}; available: {', '.join(modules)}{hint(name, modules)}")
        for key, value in adapter.items():
            if key not in ADAPTER:
                raise UsageError(f"usb of {name}: no key {key!r}; allowed {', '.join(ADAPTER)}{hint(key, ADAPTER)}")
            number = key in ("vid", "pid")
            if not isinstance(value, int if number else str) or (number and not 0 <= int(value) <= 0xFFFF):
                raise UsageError(f"usb of {name}: {key} {value!r}; allowed {'0 to 0xFFFF' if number else 'text'}")


def check_class(library: str, cls: object, base: type) -> None:
    """Check that the library's name for its serial port class still refers to that class.

    Raises:
        UsageError: another object, such as a mock or a guard of a test suite, has replaced the class.
    """
    if not (isinstance(cls, type) and issubclass(cls, base)):
        raise UsageError(
            f"{library}.Serial is {cls!r}: a test or a conftest.py has replaced it, so programs cannot open modules "
            "with it; do not replace it in tests that use modules: a port that does not exist cannot be opened anyway"
        )


@contextmanager
def named_ports(modules: Mapping[str, Controller], usb: Mapping[str, Usb] | None = None) -> Iterator[Ports]:
    """Let programs find modules under port names for the duration of the block.

    Args:
        modules: the modules, keyed by port name; they are in this process (`on="url"`).
        usb: the adapters' entries in the port list, keyed by port name; an entry may contain vid, pid, serial_number,
            manufacturer, product, location and interface.

    Raises:
        UsageError: a module has no serial line, or is already on a port of this machine; `usb` has an unknown port or
            key; or another object has replaced the class of pySerial or serialx.
    """
    check_modules(modules)
    check_adapters(modules, usb or {})
    known = {plain(name): module for name, module in modules.items()}
    adapters = {plain(name): adapter for name, adapter in (usb or {}).items()}
    with ExitStack() as stack:
        for library, lend in (("serial", _pyserial), ("serialx", _serialx)):
            if find_spec(library) is not None:
                lend(stack, import_module(library), known, adapters)
        yield Ports(modules)


# ------------------------------------------------------------------------------------------------------------- pySerial
def _pyserial(stack: ExitStack, serial: Any, known: Mapping[str, Controller], usb: Mapping[str, Usb]) -> None:
    from .protocol_slewline import Serial

    def mine(port: Any) -> bool:
        name = plain(port.port)
        return name in known and (not port.is_open or vars(port).get("_url") == port.port)

    check_class("serial", serial.Serial, serial.SerialBase)
    _lend(stack, serial.Serial, {**vars(HasRig), **vars(Serial)}, mine, lambda port: known[plain(port.port)].rig)
    from serial.tools import list_ports
    from serial.tools.list_ports_common import ListPortInfo

    listed = list_ports.comports

    def shown(name: str) -> Any:
        info = ListPortInfo(name)
        if name in usb:
            vars(info).update(usb[name])
            info.apply_usb_info()
        return info

    def comports(*arguments: Any, **more: Any) -> list[Any]:
        here = [shown(name) for name, module in known.items() if not module.rig.away]
        return [*here, *(info for info in listed(*arguments, **more) if info.device not in known)]

    _put(stack, list_ports, "comports", comports)


# -------------------------------------------------------------------------------------------------------------- serialx
def _serialx(stack: ExitStack, serialx: Any, known: Mapping[str, Controller], usb: Mapping[str, Usb]) -> None:
    from serialx import SerialPortInfo, async_serial, common

    from .for_serialx import Serial, Transport

    def found(port: Any) -> Any:
        return known[plain(port.path)].rig

    class Named(Serial):
        _found = found

    class NamedTransport(Transport):
        make = Named

    handler_of = common.get_uri_handler

    def get_uri_handler(uri: str) -> Any:
        handler = handler_of(uri)
        return replace(handler, async_transport_cls=NamedTransport) if plain(uri) in known else handler

    def shown(name: str) -> Any:
        adapter: dict[str, Any] = dict(usb.get(name, {}))
        adapter["interface_description"] = adapter.pop("interface", None)
        adapter.pop("location", None)
        names = ("vid", "pid", "serial_number", "manufacturer", "product", "bcd_device", "interface_num")
        return SerialPortInfo(name, name, **{**dict.fromkeys(names), **adapter})

    check_class("serialx", serialx.Serial, common.BaseSerial)
    listed = common.list_serial_ports

    def list_serial_ports(*arguments: Any, **more: Any) -> list[Any]:
        here = [shown(name) for name, module in known.items() if not module.rig.away]
        return [*here, *(info for info in listed(*arguments, **more) if info.device not in known)]

    async def async_list_serial_ports(*arguments: Any, **more: Any) -> list[Any]:
        return list_serial_ports(*arguments, **more)

    for module in (serialx, common):
        _put(stack, module, "list_serial_ports", list_serial_ports)
        _put(stack, module, "async_list_serial_ports", async_list_serial_ports)
    _lend(stack, serialx.Serial, {**vars(HasRig), **vars(Serial)}, lambda port: plain(port.path) in known, found)
    for module in (common, async_serial):
        _put(stack, module, "get_uri_handler", get_uri_handler)


# --------------------------------------------------------------------------------------------- methods added to a class
def _lend(
    stack: ExitStack, cls: type, own: Mapping[str, Any], mine: Callable[[Any], bool], found: Callable[[Any], Rig]
) -> None:
    """Replace methods of `cls` by those in `own`, but only for objects for which `mine` returns True.

    When `stack` is closed, any such objects that are still open are closed, too.
    """
    opened: WeakSet[Any] = WeakSet()

    def noted(port: Any) -> Rig:
        opened.add(port)
        return found(port)

    for name, ours in {**own, "_found": noted}.items():
        if name.startswith("__") or name == "_abc_impl":  # every class has its own
            continue
        theirs = getattr_static(cls, name, MISSING)
        if theirs is MISSING and name in ELSEWHERE:
            theirs = _missing(cls, name)
        if theirs is MISSING or not (callable(ours) or isinstance(ours, property)):
            _put(stack, cls, name, ours)
        elif isinstance(ours, property):
            _put(stack, cls, name, _either_property(ours, theirs, mine))
        else:
            _put(stack, cls, name, _either(ours, theirs, mine))
    stack.callback(_close, opened)


def _close(ports: WeakSet[Any]) -> None:
    for port in list(ports):
        if port.is_open:
            port.close()


def _missing(cls: type, name: str) -> Callable[..., Any]:
    """Return a stand-in for the method `name`, which `cls` lacks; on a real port, it raises AttributeError."""

    def method(self: Any, *arguments: Any, **more: Any) -> NoReturn:
        raise AttributeError(f"{cls.__name__!r} object has no attribute {name!r}")

    return method


def _either(ours: Callable[..., Any], theirs: Callable[..., Any], mine: Callable[[Any], bool]) -> Callable[..., Any]:
    def method(self: Any, *arguments: Any, **more: Any) -> Any:
        return (ours if mine(self) else theirs)(self, *arguments, **more)

    return method


def _either_property(ours: property, theirs: Any, mine: Callable[[Any], bool]) -> property:
    def get(self: Any) -> Any:
        return ours.__get__(self) if mine(self) else theirs.__get__(self, type(self))

    return property(get, getattr(theirs, "fset", None))


def _put(stack: ExitStack, where: Any, name: str, value: Any) -> None:
    """Set an attribute of `where`, and restore its previous state when the stack is closed."""
    before = vars(where).get(name, MISSING)
    setattr(where, name, value)
    stack.callback(delattr, where, name) if before is MISSING else stack.callback(setattr, where, name, before)
