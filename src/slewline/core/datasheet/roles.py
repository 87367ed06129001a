"""Names for the purpose of pins and commands, shared by all parts: hosts, parts, wiring, rules and texts use them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

AXIS_ROLES: Mapping[str, str] = MappingProxyType(  # a pin of an axis that ...
    {
        "step": "shows every step",
        "direction": "gives the direction; high, or at the level that is named: clockwise, or positive",
        "moving": "shows that the motor is moving",
        "ramping": "shows that the motor is accelerating or decelerating",
        "slewing": "shows that the motor is running at its steady rate",
        "motion_complete": "shows that a motion is complete",
        **{f"phase{n}": f"energises phase {n} of a motor with four phases" for n in (1, 2, 3, 4)},
        "driver_reset": "puts the driver into its first state",
        "enable": "enables the next step, or holds it",
        "abort": "stops the motion",
        "home": "shows the chip that the motor is at its home position",
        "end": "shows the chip that the motor is at either end of its travel",
        "end_plus": "shows the chip that the motor is at the end of its travel in the positive direction",
        "end_minus": "shows the chip that the motor is at the end of its travel in the negative direction",
        "jog": "steps the motor by hand",
        "encoder_a": "takes channel A of an encoder, ahead of B in the positive direction",
        "encoder_b": "takes channel B of an encoder",
        "index": "takes the index mark of an encoder, once per turn",
    }
)
ROLES: Mapping[str, str] = MappingProxyType(  # the purpose of a pin; parts that are wired `to` a neighbour use it
    {
        **AXIS_ROLES,
        **{f"output{n}": f"is output {n} that programs set" for n in (1, 2, 3)},
        **{f"input{n}": f"is input {n} that programs read" for n in (1, 2, 3)},
        "running": "shows that a program is running",
        "program_entry": "shows that a program is being entered",
        "reset": "resets the part",
        "clock": "puts out a clock that never stops: recorded only when it is named",
        # the port of a host
        "data": "is a wire of the data bus",
        "ready": "shows that the part is ready for a command or a byte",
        "request": "asks the part to take a byte, or to give one",
        "select": "says whether the host or the part drives the data bus",
        "in_strobe": "shows that a byte is being read from the data bus",
        "out_strobe": "shows that a byte is being put on the data bus",
        "text": "says whether commands are text or binary",
        "flow": "says which way the bytes of a message go; low: the part has bytes for its host",
        "chip_select": "selects the part",
        "command": "says whether a command or data are on the data bus",
        "write": "writes a byte from the data bus",
        "read": "reads a byte onto the data bus",
        "interrupt": "interrupts the host",
        "serial_in": "receives characters from a computer",
        "serial_out": "sends characters to a computer",
        "serial_pull_down": "pulls low a line that modules share",
        "computer_in": "is the input of a computer's serial port",
        "computer_out": "is the output of a computer's serial port",
        # the bus of a part with its own memory and displays
        "memory_select": "selects the memory; the high byte of the address is on the bus at that edge",
        "display_select": "selects a display",
        "switch_select": "selects thumbwheel switches",
        "address_latch": "says when the low byte of an address is on the bus",
        "read_strobe": "lets the selected part drive the bus",
        "write_strobe": "lets the selected part take what is on the bus",
        # IEEE-488
        "dio": "is a data line of an IEEE-488 bus",
        **{line: f"is {line.upper()} of an IEEE-488 bus" for line in ("dav", "nrfd", "ndac", "atn", "ifc", "srq")},
    }
)

REFLEXES: Mapping[str, str] = (
    MappingProxyType(  # an input that stops the motor directly, so a board reacts immediately: it ...
        {
            "stop": "stops the motor: the running step is its last one",
            "stop up": "does so while the motor runs in positive direction",
            "stop down": "does so while the motor runs in negative direction",
            "brake": "slows the motor down, and stops it",
            "brake back": "slows the motor down by as many steps as it has sped up, and stops it",
            "hold": "holds the motor as long as the level lasts; every step that is to come is later then",
            "mark": "notes where the motor is, which goes on",
            "stop out": "stops the motor on the way out of a homing",
            "stop back": "stops the motor on the way back of a homing",
            "stop sought": "stops the motor in a homing that seeks its level, if it seeks that of this pin alone",
        }
    )
)
AT_ONCE: Mapping[str, str] = MappingProxyType(  # a command that does not wait for the end of a motion: it ...
    {
        "stop": "stops the motor: the running step is its last one",
        "brake": "slows the motor down, and stops it",
    }
)

ROW_ROLES: Mapping[str, str] = MappingProxyType(  # a command that ...
    {
        "enter": "begins program entry",
        "leave": "ends program entry",
        "run": "runs the program from its start",
        "stop": "ends the program that runs",
        "erase": "erases the program, and ends a running one",
        "loop": "repeats a part of the program a number of times",
        "pointer": "sets where the program that is entered or run next begins",
        "mark": "marks where such a repetition begins",
        "read": "selects what is to be read back",
        "list": "asks for the program, in as many lines as it takes",
        "state": "asks whether the part is busy",
        "question": "asks for a value, and changes nothing",
        "goto": "moves to a position",
        "home": "finds the home position",
        "preset": "sets the position, without motion",
        "store": "keeps the program without power",
        "recall": "puts the program that is kept without power in the place of the other",
        # the effect on the motor, used to translate a program for another part
        "start_rate": "sets the rate at which motions start and end",
        "top_rate": "sets the rate of motions between their ramps",
        "ramp": "sets how the rate rises from the one to the other",
        "ramp_divisor": "divides the rise of the rate",
        "rate_divisor": "divides the rate of motions without ramps",
        "half_steps": "lets each step be half a step",
        "distance": "sets the number of steps of the relative moves that follow",
        "target": "sets the position to which the next motion goes",
        "absolute": "moves to a position, as a part does that no computer asks where it is",
        "phases": "sets the phases to a step of their pattern",
        "plus": "sets the direction of the relative moves that follow: clockwise",
        "minus": "sets their direction: counter-clockwise",
        "move": "moves by a number of steps",
        "single": "takes one step",
        "endless": "runs until something stops it",
        "endless_next": "lets the next motion run until something stops it",
        "until_input": "runs until an input is low",
        "update": "lets the motions that were set begin",
        "clear_events": "clears the events of an axis",
        "axis": "selects the axis that the following commands are about",
        "clear": "sets the position, outputs or both to zero",
        "output_high": "sets an output high",
        "output_low": "sets an output low",
        "bits": "sets or clears outputs that its number names",
        "wait_high": "waits until an input is high",
        "wait_low": "waits until an input is low",
        "wait_bits": "waits until inputs that its number names have their levels",
        "branch_high": "continues elsewhere if an input is high",
        "branch_low": "continues elsewhere if an input is low",
        "branch_inputs": "continues elsewhere if all inputs have their levels",
        "branch_bits": "continues elsewhere until inputs that its number names have their levels",
        "jump": "continues elsewhere",
        "delay": "waits for a time",
    }
)
