"""What pins and commands are for, in words that all parts share: hosts, parts, wiring, rules and texts go by them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

AXIS_ROLES: Mapping[str, str] = MappingProxyType(  # a pin of an axis that ...
    {
        "step": "shows every step",
        "direction": "gives the direction; high, or at the level that is named: clockwise, or positive",
        "moving": "tells that the motor is under way",
        "ramping": "tells that it speeds up or slows down",
        "slewing": "tells that it runs at its steady rate",
        "motion_complete": "tells that a motion is complete",
        **{f"phase{n}": f"energises phase {n} of a motor with four phases" for n in (1, 2, 3, 4)},
        "driver_reset": "puts the driver into its first state",
        "enable": "lets the next step be made, or holds it",
        "abort": "stops the motion",
        "home": "is told that the motor is at its home position",
        "end": "is told that it is at an end of its travel, whichever",
        "end_plus": "is told that it is at the end of its travel in positive direction",
        "end_minus": "is told that it is at the end of its travel in negative direction",
        "jog": "lets a hand step the motor",
        "encoder_a": "takes channel A of an encoder, ahead of B in positive direction",
        "encoder_b": "takes channel B of an encoder",
        "index": "takes the mark of an encoder, once a turn",
    }
)
ROLES: Mapping[str, str] = MappingProxyType(  # what a pin is for; parts that are wired `to` a neighbour go by it
    {
        **AXIS_ROLES,
        **{f"output{n}": f"is output {n} of those that programs switch" for n in (1, 2, 3)},
        **{f"input{n}": f"is input {n} of those that programs look at" for n in (1, 2, 3)},
        "running": "tells that a program runs",
        "program_entry": "tells that a program is being entered",
        "reset": "resets the part",
        "clock": "puts out a clock that never rests: recorded only when it is named",
        # the port of a host
        "data": "is a wire of the data bus",
        "ready": "tells that a command or a byte may come",
        "request": "asks for a byte to be taken, or to be given",
        "select": "says whether the host or the part drives the data bus",
        "in_strobe": "tells that a byte is being read from the data bus",
        "out_strobe": "tells that a byte is put on the data bus",
        "text": "says whether commands are text or binary",
        "flow": "says which way the bytes of a message go; low: the part has some for its host",
        "chip_select": "selects the part",
        "command": "says whether a command or data are on the data bus",
        "write": "writes a byte from the data bus",
        "read": "reads a byte onto the data bus",
        "interrupt": "calls the host",
        "serial_in": "takes characters from a computer",
        "serial_out": "gives characters to a computer",
        "serial_pull_down": "pulls a line low that modules share",
        "computer_in": "is the input of a computer's serial port",
        "computer_out": "is the output of a computer's serial port",
        # the bus of a part that has memory and displays of its own
        "memory_select": "selects the memory, whose high address is on the bus as it becomes so",
        "display_select": "selects a display",
        "switch_select": "selects thumbwheel switches",
        "address_latch": "says when the low byte of an address is on the bus",
        "read_strobe": "lets what is selected drive the bus",
        "write_strobe": "lets what is selected take what is on the bus",
        # IEEE-488
        "dio": "is a data line of an IEEE-488 bus",
        **{line: f"is {line.upper()} of an IEEE-488 bus" for line in ("dav", "nrfd", "ndac", "atn", "ifc", "srq")},
    }
)

ROW_ROLES: Mapping[str, str] = MappingProxyType(  # a command that ...
    {
        "enter": "begins program entry",
        "leave": "ends program entry",
        "run": "runs the program from its start",
        "stop": "ends the program that runs",
        "erase": "forgets the program, and ends one that runs",
        "loop": "repeats a part of the program so many times",
        "pointer": "says where the program begins that is entered, or run, next",
        "mark": "stands where such a repetition begins",
        "read": "says what is to be read back",
        "list": "asks for the program, in as many lines as it takes",
        "state": "asks whether the part is busy",
    }
)
