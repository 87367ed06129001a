"""What the CY5xx family shares: objects that a chip of it owns, each with few others that it knows.

    registers.py      parameters, and what RESET and I clear
    phase_outputs.py  PULSE, the phases, DIRECTION, SLEW
    command_port.py   a byte in, a verify byte out; the only writer of READY
    readout.py        which byte a read-out gives next
    motion.py         plays what a part plans
    program_buffer.py the program buffer, and where it runs
    instructions.py   what commands do, one method a row of the sheet
    interpreter.py    commands as they come, the stored program, live commands
    supply.py         power, RESET
    firmware.py       the chip that owns them, and its public face

Each object knows those above it in this list, never one below: what it must tell those it tells through a few methods
that it names itself.  A part brings its sheet, its law of motion, and what it does in another way.

Beside them:

    slope.py          the law of parts whose rate parameter grows by S with each step; sloped.py: what they do alike
    unit_ramps.py     the law of parts whose rate grows with time; ramps.py: the calculator of both
    twin.py           the same motions step by step
    crystal.py        times in clocks, and crystals that do not fit
    sheet.py          what the sheets of the parts in the same socket begin with
    family_options.py, letters.py: data for sheets; checks.py: for linters
"""
