"""What stands around a chip: an explicit list, no scanning.

    bench.part("uart", to="x", baud=9600)

With `to`, the pins of the part are wired to those of a neighbour in the standard way.
"""

from __future__ import annotations

from importlib import import_module
from inspect import signature
from typing import TYPE_CHECKING, Any

from ..core.option import checked
from ..errors import UnknownName, UsageError

if TYPE_CHECKING:
    from ..core.kernel import Kernel
    from ..core.shaft import Shaft
    from .part import Part

KINDS = {  # kind: (module, class, what it is)
    "inverter": ("gates", "Inverter", "one gate of a 7404"),
    "and": ("gates", "And", "AND gate"),
    "or": ("gates", "Or", "OR gate"),
    "nand": ("gates", "Nand", "NAND gate"),
    "nor": ("gates", "Nor", "NOR gate"),
    "delay": ("gates", "Delay", "delay line"),
    "latch8": ("gates", "Latch8", "74LS373, eight transparent latches with output enable"),
    "uart": ("serial", "Uart", "receive-only UART with baud rate generator (fig. 10.16)"),
    "serial_sender": ("serial", "SerialSender", "serial output of a host computer"),
    "serial_port": ("rs232", "SerialPort", "serial connector of a computer, RS-232 or TTL"),
    "rs232_line": ("rs232_line", "Rs232Line", "RS-232 line on which characters are lost, garbled or come with faults"),
    "prom": ("prom", "Prom", "PROM with address counter: commands without a host (fig. 10.18)"),
    "position_latch": ("latches", "PositionLatch", "two latches that catch the position on the fly (fig. 6.3)"),
    "phase_latch": ("latches", "PhaseLatch", "latch that keeps the coils energised (fig. 4.1)"),
    "translator": ("motor", "Translator", "pulse-to-step translator (fig. 10.4)"),
    "rotor": ("motor", "Rotor", "rotor between two windings"),
    "motor": ("motor", "Motor", "motor that may lose steps, with the detector of its steps (GS-C fig. 14, 17, 18)"),
    "encoder": ("encoder", "Encoder", "encoder on the shaft of a step motor, which may be blocked or slip"),
    "switch": ("sensors", "Switch", "home or limit switch on a shaft or a carriage"),
    "gear": ("carriage", "Gear", "gear between two shafts"),
    "carriage": ("carriage", "Carriage", "carriage that a shaft moves, with backlash and hard stops"),
    "quadrature": ("encoder", "Quadrature", "encoder on a shaft that another machine turns, the master of a gear"),
    "gs_d200": ("gsd200", "GsD200", "GS-D200 or GS-D200S driver module: translator and enable (GS-C fig. 7)"),
    "phase_current": ("gsd200", "PhaseCurrent", "phase current that MOV and RAMP choose (GS-C fig. 6, 11)"),
    "two_clocks": ("gsc_circuits", "TwoClocks", "a clock line for each direction (GS-C fig. 10)"),
    "step_check": ("gsc_circuits", "StepCheck", "closes the loop through ENABLE (GS-C fig. 19)"),
    "damping": ("gsc_circuits", "Damping", "brakes the last step of a move (GS-C fig. 23)"),
    "bar": ("drilling", "Bar", "bar that is fed, drilled and cut (GS-C example 2)"),
    "drill": ("drilling", "Drill", "drill that is lowered and lifted (GS-C example 2)"),
    "ppi8255": ("computer8080", "Ppi8255", "8080 with 8255 ports (Table IX)"),
    "host8080": ("computer8080", "Host8080", "8080 with one output port (fig. 5.3)"),
    "keyboard": ("keyboard", "Keyboard", "keyboard with write strobe generator (fig. 10.8)"),
    "isa": ("isa", "Isa", "ISA board of a PC: the host port of an MC1451A as I/O addresses"),
    "gpib_listener": ("gpib", "GpibListener", "simple IEEE-488 listener (fig. 12.4)"),
    "gpib_talker": ("gpib", "GpibTalker", "IEEE-488 talker for the simple listener (fig. 12.3)"),
    "gpib_device": ("gpib_device", "GpibDevice", "IEEE-488 talker and listener with address (fig. 12.8)"),
    "gpib_controller": ("gpib_device", "GpibController", "IEEE-488 controller"),
    "gpib_interrupts": ("gpib_device", "GpibInterrupts", "IEEE-488 interrupt logic (fig. 12.9)"),
    "workpieces": ("welding", "Workpieces", "workpieces under a welding machine"),
    "welder": ("welding", "Welder", "carriage and torch of a welding machine"),
}


def part_class(kind: str) -> type[Part]:
    """The class of a part by its kind, for example "uart"."""
    try:
        module, name, _ = KINDS[kind]
    except KeyError:
        raise UnknownName(f"no part {kind!r}; there are: {', '.join(KINDS)}") from None
    return getattr(import_module(f"{__name__}.{module}"), name)  # type: ignore[no-any-return]


def make_part(kind: str, kernel: Kernel, name: str, options: dict[str, Any], **mounted: Shaft) -> Part:
    """Return a part of a kind, on a shaft where it sits on one; its constructor gets every option, checked.

    Raises:
        UnknownName: no such kind.
        UsageError: an option that the kind does not have, or does not allow.
    """
    cls = part_class(kind)
    parameters = [parameter for parameter in list(signature(cls).parameters)[2:] if parameter != "on"]
    if cls.options or not parameters:
        return cls(kernel, name, **mounted, **checked(name, cls.options, options))
    for key in options:
        if key not in parameters:
            raise UsageError(f"{name}: no option {key!r}; its options: {', '.join(parameters)}")
    return cls(kernel, name, **mounted, **options)
