"""Real motors: a board outputs the steps of a model; from the bytes on its wire to the axis that it drives.

A driver with STEP and DIR inputs is a row of `STEP_DRIVERS` in `step_drivers.py`, with its data sheet.  Output passes
through `feeder.py` (steps) and `cable.py` (pins, characters), which delay it by a horizon; `drive_state.py` has the
state that all pieces share, and `motor_drive.py` joins them.
"""
