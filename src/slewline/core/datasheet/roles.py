"""Names for the purposes of pins and commands, shared by all parts; hosts, parts, wiring, rules and texts use them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

AXIS_ROLES: Mapping[str, str] = MappingProxyType(  # a pin of an axis that ...
    {
        "step": "shows every step",
        "direction": "shows the direction: high, or the level given in the pin table, is clockwise or positive",
        "moving": "shows that the motor is moving",
        "ramping": "shows that the motor is accelerating or decelerating",
        "slewing": "shows that the motor is running at its steady rate",
        "motion_complete": "shows that a motion is complete",
        **{f"phase{n}": f"energises phase {n} of a motor with four phases" for n in (1, 2, 3, 4)},
        "driver_reset": "sets the driver to its first state",
        "enable": "enables the next step, or holds it back",
        "abort": "stops the motion",
        "home": "signals that the motor is at its home position",
        "end": "signals that the motor is at either end of its travel",
        "end_plus": "signals that the motor is at the end of its travel in the positive direction",
        "end_minus": "signals that the motor is at the end of its travel in the negative direction",
        "jog": "steps the motor by hand",
        "encoder_a": "receives channel A of an encoder, ahead of B in the positive direction",
        "encoder_b": "receives channel B of an encoder",
        "index": "receives the index mark of an encoder, once per revolution",
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
        "clock": "outputs a clock that never stops: recorded only when it is named",
        # the port of a host
        "data": "is a wire of the data bus",
        "ready": "shows that the part is ready for a command or a byte",
        "request": "requests that the part read or output a byte",
        "select": "selects whether the host or the part drives the data bus",
        "in_strobe": "shows that a byte is being read from the data bus",
        "out_strobe": "shows that a byte is being put on the data bus",
        "text": "selects text or binary commands",
        "flow": "shows the direction of the bytes of a message; low: from the part to its host",
        "chip_select": "selects the part",
        "command": "shows whether a command or data are on the data bus",
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
        "address_latch": "shows when the low byte of an address is on the bus",
        "read_strobe": "lets the selected part drive the bus",
        "write_strobe": "lets the selected part read the byte on the bus",
        # IEEE-488
        "dio": "is a data line of an IEEE-488 bus",
        **{line: f"is {line.upper()} of an IEEE-488 bus" for line in ("dav", "nrfd", "ndac", "atn", "ifc", "srq")},
    }
)

REFLEXES: Mapping[str, str] = (
    MappingProxyType(  # an input that stops the motor directly, so a board reacts immediately: it ...
        {
            "stop": "stops the motor after the current step",
            "stop up": "stops the motor while it runs in the positive direction",
            "stop down": "stops the motor while it runs in the negative direction",
            "brake": "decelerates the motor to a stop",
            "brake back": "decelerates the motor to a stop, over as many steps as it has accelerated",
            "hold": "holds the motor while the level lasts, which delays all further steps",
            "mark": "latches the position, and the motor keeps moving",
            "stop out": "stops the motor in the outward phase of homing",
            "stop back": "stops the motor in the return phase of homing",
            "stop sought": "stops the motor when homing seeks the level of this pin alone",
        }
    )
)
AT_ONCE: Mapping[str, str] = MappingProxyType(  # a command that does not wait for the end of a motion: it ...
    {
        "stop": "stops the motor after the current step",
        "brake": "decelerates the motor to a stop",
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
        "pointer": "sets the start of the next program to be entered or run",
        "mark": "marks the start of such a repetition",
        "read": "selects the data to be read back",
        "list": "queries the program, which may take several lines",
        "state": "queries whether the part is busy",
        "question": "queries a value, and changes nothing",
        "goto": "moves to a position",
        "home": "finds the home position",
        "preset": "sets the position, without motion",
        "store": "saves the program to non-volatile memory",
        "recall": "restores the program from non-volatile memory",
        # the effect on the motor, used to translate a program for another part
        "start_rate": "sets the rate at which motions start and end",
        "top_rate": "sets the rate of motions between their ramps",
        "ramp": "sets the acceleration between the two",
        "ramp_divisor": "divides the acceleration",
        "rate_divisor": "divides the rate of motions without ramps",
        "half_steps": "selects half steps",
        "distance": "sets the number of steps of the relative moves that follow",
        "target": "sets the target of the next motion",
        "absolute": "moves to a position, on a part that does not report its position",
        "phases": "sets the phases to a step of their pattern",
        "plus": "sets the direction of the relative moves that follow: clockwise",
        "minus": "sets their direction: counter-clockwise",
        "move": "moves by a number of steps",
        "single": "takes one step",
        "endless": "runs until it is stopped",
        "endless_next": "lets the next motion run until it is stopped",
        "until_input": "runs until an input is low",
        "update": "starts the motions that were set",
        "clear_events": "clears the events of an axis",
        "axis": "selects the axis for the following commands",
        "clear": "sets the position, outputs or both to zero",
        "output_high": "sets an output high",
        "output_low": "sets an output low",
        "bits": "sets or clears the outputs given by its number",
        "wait_high": "waits until an input is high",
        "wait_low": "waits until an input is low",
        "wait_bits": "waits until the inputs given by its number have their levels",
        "branch_high": "jumps if an input is high",
        "branch_low": "jumps if an input is low",
        "branch_inputs": "jumps if all inputs have their levels",
        "branch_bits": "jumps until the inputs given by its number have their levels",
        "jump": "jumps",
        "delay": "waits for a time",
    }
)
