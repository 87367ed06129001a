"""Parts around a chip: built-in parts (an explicit list), and plug-ins (module:Class, or an entry point).

    bench.part("uart", to="x", baud=9600)
    bench.part("my_lab.lamp:Lamp", to="x")

`to` names a chip or part; the new part is wired to its pins in the standard way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ..core.datasheet.catalogue import Catalogue
from ..core.datasheet.option import Option, checked
from .base.part import Part

if TYPE_CHECKING:
    from ..core.time.kernel import Kernel
    from .shafts.shaft import Shaft


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedPart:
    """A kind of part: its description, and the location of its class as `module:name` within this folder.

    `fixed` has the values of those options of the class that define the kind; users cannot set these options.
    """

    description: str
    at: str
    fixed: Mapping[str, Any] = field(default_factory=dict)


# fmt: off
KINDS = {
    "inverter": ListedPart(at="logic.gates:Gate", fixed={"function": "nand", "inputs": 1}, description="one gate of a 7404"),
    "and": ListedPart(at="logic.gates:Gate", fixed={"function": "and"}, description="AND gate"),
    "or": ListedPart(at="logic.gates:Gate", fixed={"function": "or"}, description="OR gate"),
    "nand": ListedPart(at="logic.gates:Gate", fixed={"function": "nand"}, description="NAND gate"),
    "nor": ListedPart(at="logic.gates:Gate", fixed={"function": "nor"}, description="NOR gate"),
    "delay": ListedPart(at="logic.gates:Delay", description="delay line"),
    "latch8": ListedPart(at="logic.gates:Latch8", description="74LS373, eight transparent latches with output enable"),
    "uart": ListedPart(at="lines.serial_to_parallel:Uart", description="receive-only UART with baud rate generator (fig. 10.16)"),
    "serial_sender": ListedPart(at="lines.serial_to_parallel:SerialSender", description="serial output of a host computer"),
    "serial_port": ListedPart(at="lines.rs232:SerialPort", description="serial connector of a computer, RS-232 or TTL"),
    "rs232_line": ListedPart(at="lines.rs232_line:Rs232Line", description="RS-232 line with lost, garbled and faulty characters"),
    "prom": ListedPart(at="memories.prom:Prom", description="PROM with address counter: commands without a host (fig. 10.18)"),
    "ram": ListedPart(at="memories.memory:Ram", fixed={"writable": True}, description="RAM of up to 64K bytes on the bus of a chip, with its address latches"),
    "eeprom": ListedPart(at="memories.memory:Eeprom", description="EEPROM of up to 64K bytes on the bus of a chip: slow to write, non-volatile"),
    "eprom": ListedPart(at="memories.memory:Ram", fixed={"writable": False}, description="EPROM of up to 64K bytes on the bus of a chip: read only"),
    "thumbwheels": ListedPart(at="front_panel.panel_parts:Thumbwheels", description="thumbwheel switches that set the number of a command"),
    "hp_display": ListedPart(at="front_panel.displays:HpDisplay", description="eight-character LED display HDSP-211x on the bus of a chip"),
    "lcd": ListedPart(at="front_panel.displays:Lcd", description="serial LCD: texts on the right, parameters on the left"),
    "jog_switch": ListedPart(at="front_panel.panel_parts:JogSwitch", description="three-position switch for jogging"),
    "position_latch": ListedPart(at="logic.latches:PositionLatch", description="two latches for the position on the fly (fig. 6.3)"),
    "phase_latch": ListedPart(at="logic.latches:PhaseLatch", description="latch that keeps the coils energised (fig. 4.1)"),
    "translator": ListedPart(at="shafts.motor:Translator", description="pulse-to-step translator (fig. 10.4)"),
    "rotor": ListedPart(at="shafts.motor:Rotor", description="rotor between two windings"),
    "motor": ListedPart(at="shafts.motor:Motor", description="motor that may lose steps, with step detector (GS-C fig. 14, 17, 18)"),
    "stepper": ListedPart(at="steppers.stepper:Stepper", description="stepper motor with driver and load, modelled by their equations: it loses steps like a real one"),
    "encoder": ListedPart(at="shafts.encoder:Encoder", description="encoder on the shaft of a stepper motor, which may be blocked or slip"),
    "switch": ListedPart(at="shafts.sensors:Switch", description="home or limit switch on a shaft or a carriage"),
    "gear": ListedPart(at="shafts.carriage:Gear", description="gear between two shafts"),
    "carriage": ListedPart(at="shafts.carriage:Carriage", description="carriage that a shaft moves, with backlash and hard stops"),
    "quadrature": ListedPart(at="shafts.encoder:Quadrature", description="encoder on a shaft that another machine turns, the master of a gear"),
    "gs_d200": ListedPart(at="drivers.gsd200:GsD200", description="GS-D200 or GS-D200S driver module: translator and enable (GS-C fig. 7)"),
    "phase_current": ListedPart(at="drivers.gsd200:PhaseCurrent", description="phase current that MOV and RAMP select (GS-C fig. 6, 11)"),
    "two_clocks": ListedPart(at="drivers.gsc_circuits:TwoClocks", description="a clock line for each direction (GS-C fig. 10)"),
    "step_check": ListedPart(at="drivers.gsc_circuits:StepCheck", description="loop closed through ENABLE (GS-C fig. 19)"),
    "damping": ListedPart(at="drivers.gsc_circuits:Damping", description="damping of the last step of a move (GS-C fig. 23)"),
    "bar": ListedPart(at="machines.drilling:Bar", description="bar that is fed, drilled and cut (GS-C example 2)"),
    "drill": ListedPart(at="machines.drilling:Drill", description="drill that is lowered and lifted (GS-C example 2)"),
    "ppi8255": ListedPart(at="boards.computer8080:Ppi8255", description="8080 with 8255 ports (Table IX)"),
    "host8080": ListedPart(at="boards.computer8080:Host8080", description="8080 with one output port (fig. 5.3)"),
    "keyboard": ListedPart(at="front_panel.keyboard:Keyboard", description="keyboard with write strobe generator (fig. 10.8)"),
    "parallel_card": ListedPart(at="boards.parallel_card:ParallelCard", description="parallel card of a PC: a bidirectional bus at I/O addresses"),
    "isa": ListedPart(at="boards.isa:Isa", description="ISA board of a PC: the host port of an MC1451A at I/O addresses"),
    "gpib_listener": ListedPart(at="boards.gpib:GpibListener", description="simple IEEE-488 listener (fig. 12.4)"),
    "gpib_talker": ListedPart(at="boards.gpib:GpibTalker", description="IEEE-488 talker for the simple listener (fig. 12.3)"),
    "gpib_device": ListedPart(at="boards.gpib_device:GpibDevice", description="IEEE-488 talker and listener with address (fig. 12.8)"),
    "gpib_controller": ListedPart(at="boards.gpib_device:GpibController", description="IEEE-488 controller"),
    "gpib_interrupts": ListedPart(at="boards.gpib_device:GpibInterrupts", description="IEEE-488 interrupt logic (fig. 12.9)"),
    "workpieces": ListedPart(at="machines.welding:Workpieces", description="workpieces under a welding machine"),
    "welder": ListedPart(at="machines.welding:Welder", description="carriage and torch of a welding machine"),
}
# fmt: on


CATALOGUE = Catalogue("part", Part, "slewline.parts", {kind: f"{__name__}.{row.at}" for kind, row in KINDS.items()})


def part_class(kind: str, *, allow_code: bool = True) -> type[Part]:
    """Return the class of a kind of part: a built-in kind ("uart"), the name of an entry point, or module:Class.

    Args:
        allow_code: whether `kind` may be module:Class; importing it runs the module's code.

    Raises:
        UnknownName: the kind is unknown; the message lists the known kinds.
        UsageError: module:Class is not allowed, or does not name the class of a part.
    """
    return CATALOGUE.load(kind, allow_code=allow_code)


def options_of(cls: type[Part], fixed: Mapping[str, Any]) -> tuple[Option, ...]:
    """Return the options of a class that a user may set: all except the options in `fixed`."""
    return tuple(row for row in cls.options if row.name not in fixed)


def make_part(
    cls: type[Part],
    kernel: Kernel,
    name: str,
    options: dict[str, Any],
    fixed: Mapping[str, Any] = MappingProxyType({}),
    **mounted: Shaft,
) -> Part:
    """Check all options, and return a new part of a class.

    Args:
        fixed: the values of the options that the kind fixes.
        mounted: `on`, the shaft on which the part is mounted; empty if it is not mounted.

    Raises:
        UsageError: the class does not have one of the options, or does not allow its value.
    """
    return cls(kernel, name, **mounted, **fixed, **checked(name, options_of(cls, fixed), options))
