"""What turns, and what sits on it: motors, shafts, gears and carriages, encoders and switches.

A part that PULSE and DIRECTION drive has a `StepDrive` (`motor.py`).  One that sits on a shaft is a file here with
the class attribute `sits = "must"`: its rule is a `Sensor` (`sensors.py`), and its wire shows an `EncoderChannel`,
levels that repeat with the count, or a `SwitchZone`, closed between two places (`shown.py`).  A shaft that another
shaft drives is in `carriage.py`.
"""
