"""Rotating parts, and the parts that sit on them: motors, shafts, gears, carriages, encoders and switches.

A part driven by PULSE and DIRECTION has a `StepDrive` (`motor.py`).  A part that must sit on a shaft is
in a module of this package, and its class has the attribute `sits = "must"`.  Encoders and switches
follow a shaft by means of a `Sensor` (`sensors.py`); each output is an `EncoderChannel`, whose levels
repeat periodically as the shaft turns, or a `SwitchZone`, closed between two positions (`shown.py`).
Gears and carriages are in `carriage.py`.
"""
