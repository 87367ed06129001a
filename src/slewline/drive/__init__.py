"""Real motors, driven by a board that outputs the steps of an emulated chip.

This package covers everything from the bytes on the board's wire to the axis that the board drives.
Each driver with STEP and DIR inputs is a row of `STEP_DRIVERS` in `step_drivers.py`, which names its
data sheet.  Output passes through `feeder.py` (steps) and `cable.py` (pins, characters), which delay it
by a fixed time, the horizon; `drive_state.py` has the state that these files share, and `motor_drive.py`
joins all of them.
"""
