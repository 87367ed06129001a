"""Real motors, driven by a board that outputs the steps of a model.

This package covers everything from the bytes on the board's wire to the axis that the board drives.  A
driver with STEP and DIR inputs is a row of `STEP_DRIVERS` in `step_drivers.py`, with its data sheet.
Output passes through `feeder.py` (steps) and `cable.py` (pins, characters), which delay it by a fixed
time, the horizon; `drive_state.py` has the state that all pieces share, and `motor_drive.py` joins them.
"""
