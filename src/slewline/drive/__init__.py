"""Real motors: a board that makes the steps of a model, from the bytes on its wire to the axis that it drives.

A driver with STEP and DIR is a row of `STEP_DRIVERS` in `step_drivers.py`, with the data sheet.  What goes out, a
horizon later, passes `feeder.py` (steps) and `cable.py` (pins, characters); `drive_state.py` has what all pieces share,
`motor_drive.py` joins them.
"""
