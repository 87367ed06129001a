"""The code common to the CY5xx family: the objects that a chip owns, each of which refers to only a few others.

    registers.py      parameters, and the fields that RESET and the I command clear
    phase_outputs.py  PULSE, the phases, DIRECTION, SLEW
    command_port.py   bytes in, verify bytes out; the only writer of READY
    readout.py        the next byte of a read-out
    motion.py         plays the plans of a part (a chip type)
    program_buffer.py the program buffer, and the execution address
    instructions.py   the effects of commands, one method per row of the sheet
    interpreter.py    the host's commands, the stored program, live commands
    supply.py         power, RESET
    firmware.py       the chip that owns them, and its public interface

Each object refers only to the objects above it in this list; it notifies those below it through a few
methods, which it declares itself.  A part adds its sheet, its law of motion, and its differences.

Further modules:

    slope.py          the law of parts whose rate parameter grows by S with each step
    sloped.py         the common behaviour of these parts
    unit_ramps.py     the law of parts whose rate grows with time
    ramps.py          ramp calculation for the laws of slope.py and unit_ramps.py
    twin.py           the slow twin, which makes the same motions step by step
    crystal.py        times in clocks, and crystals that the part does not allow
    sheet.py          the data common to the parts that fit the same socket
    family_options.py, letters.py: data for sheets; checks.py: lint rules
"""
