# Written by tools/stubs.py from the lists of chips and parts; change those, not this file.

from collections.abc import Mapping
from typing import Any, Literal, Protocol, TypeVar, overload

from ..chips.cy500.firmware import Cy500
from ..chips.cy512.firmware import Cy512
from ..chips.cy525.firmware import Cy525
from ..chips.cy545.firmware import Cy545, Cy545B
from ..chips.gs_c200.firmware import GsC200, GsC200S
from ..chips.line import LineChip
from ..chips.mc1451a.firmware import Mc1151A, Mc1151AE, Mc1251A, Mc1251AE, Mc1451A, Mc1451AE
from ..core.chip import Chip
from ..core.time.timebase import Time
from ..parts.base.part import Part
from ..parts.boards.computer8080 import Host8080, Ppi8255
from ..parts.boards.gpib import GpibListener, GpibTalker
from ..parts.boards.gpib_device import GpibController, GpibDevice, GpibInterrupts
from ..parts.boards.isa import Isa
from ..parts.boards.parallel_card import ParallelCard
from ..parts.drivers.gsc_circuits import Damping, StepCheck, TwoClocks
from ..parts.drivers.gsd200 import GsD200, PhaseCurrent
from ..parts.front_panel.displays import HpDisplay, Lcd
from ..parts.front_panel.keyboard import Keyboard
from ..parts.front_panel.panel_parts import JogSwitch, Thumbwheels
from ..parts.hosts.adaptive_host import AdaptiveHost
from ..parts.hosts.bus_host import BusHost
from ..parts.hosts.flow_host import FlowHost
from ..parts.hosts.host import Host
from ..parts.hosts.packet_host import PacketHost
from ..parts.hosts.serial_host import SerialHost
from ..parts.lines.rs232 import SerialPort
from ..parts.lines.rs232_line import Rs232Line
from ..parts.lines.serial_to_parallel import SerialSender, Uart
from ..parts.logic.gates import Delay, Gate, Latch8
from ..parts.logic.latches import PhaseLatch, PositionLatch
from ..parts.machines.drilling import Bar, Drill
from ..parts.machines.welding import Welder, Workpieces
from ..parts.memories.memory import Eeprom, Ram
from ..parts.memories.prom import Prom
from ..parts.shafts.carriage import Carriage, Gear
from ..parts.shafts.encoder import Encoder, Quadrature
from ..parts.shafts.motor import Motor, Rotor, Translator
from ..parts.shafts.sensors import Switch
from ..parts.steppers.stepper import Stepper

C = TypeVar("C", bound=Chip)
P = TypeVar("P", bound=Part)

class Adds(Protocol):
    @overload
    def __call__(
        self,
        /,
        part: Literal["cy525"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Cy525: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["cy500"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Cy500: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["cy512"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Cy512: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["cy545"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Cy545: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["cy545b"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Cy545B: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["gs-c200"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> GsC200: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["gs-c200s"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> GsC200S: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["mc1151a"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Mc1151A: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["mc1251a"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Mc1251A: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["mc1451a"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Mc1451A: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["mc1151a-e"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Mc1151AE: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["mc1251a-e"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Mc1251AE: ...
    @overload
    def __call__(
        self,
        /,
        part: Literal["mc1451a-e"],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Mc1451AE: ...
    @overload
    def __call__(
        self,
        /,
        part: type[C],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> C: ...
    @overload
    def __call__(
        self,
        /,
        part: str,
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Chip: ...

class Makes(Protocol):
    @overload
    def __call__(
        self,
        /,
        kind: Literal["inverter"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Gate: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["and"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Gate: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["or"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Gate: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["nand"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Gate: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["nor"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Gate: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["delay"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Delay: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["latch8"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Latch8: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["uart"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Uart: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["serial_sender"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> SerialSender: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["serial_port"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> SerialPort: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["rs232_line"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Rs232Line: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["prom"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Prom: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["ram"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Ram: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["eeprom"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Eeprom: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["eprom"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Ram: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["thumbwheels"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Thumbwheels: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["hp_display"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> HpDisplay: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["lcd"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Lcd: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["jog_switch"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> JogSwitch: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["position_latch"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> PositionLatch: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["phase_latch"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> PhaseLatch: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["translator"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Translator: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["rotor"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Rotor: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["motor"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Motor: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["stepper"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Stepper: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["encoder"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Encoder: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["switch"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Switch: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gear"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Gear: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["carriage"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Carriage: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["quadrature"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Quadrature: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gs_d200"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> GsD200: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["phase_current"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> PhaseCurrent: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["two_clocks"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> TwoClocks: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["step_check"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> StepCheck: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["damping"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Damping: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["bar"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Bar: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["drill"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Drill: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["ppi8255"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Ppi8255: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["host8080"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Host8080: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["keyboard"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Keyboard: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["parallel_card"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> ParallelCard: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["isa"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Isa: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gpib_listener"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> GpibListener: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gpib_talker"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> GpibTalker: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gpib_device"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> GpibDevice: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gpib_controller"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> GpibController: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["gpib_interrupts"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> GpibInterrupts: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["workpieces"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Workpieces: ...
    @overload
    def __call__(
        self,
        /,
        kind: Literal["welder"],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Welder: ...
    @overload
    def __call__(
        self,
        /,
        kind: type[P],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> P: ...
    @overload
    def __call__(
        self,
        /,
        kind: str,
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Part: ...

class Hosts(Protocol):
    @overload
    def __call__(
        self,
        /,
        *chips: Cy545,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: Literal["parallel"] | None = None,
    ) -> FlowHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Cy545,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: Literal["serial"],
    ) -> AdaptiveHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Cy525,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> BusHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Cy500,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> BusHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Cy512,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> BusHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: GsC200,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> SerialHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: GsC200S,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> SerialHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Mc1151A,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> PacketHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Mc1251A,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> PacketHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Mc1451A,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> PacketHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Mc1151AE,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> PacketHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Mc1251AE,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> PacketHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Mc1451AE,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> PacketHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: LineChip,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> SerialHost: ...
    @overload
    def __call__(
        self,
        /,
        *chips: Chip,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> Host: ...
