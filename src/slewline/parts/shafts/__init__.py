"""Rotating parts, and the parts that sit on them: motors, shafts, gears and carriages, encoders and switches.

A part that PULSE and DIRECTION drive has a `StepDrive` (`motor.py`).  A part that sits on a shaft is a file here with
the class attribute `sits = "must"`: its rule is a `Sensor` (`sensors.py`), and its output is an `EncoderChannel`,
whose levels repeat with the count, or a `SwitchZone`, which is closed between two positions (`shown.py`).  Shafts
that another shaft drives are in `carriage.py`.
"""
