"""Rotating parts, and the parts that sit on them: motors, shafts, gears and carriages, encoders and switches.

A part driven by PULSE and DIRECTION has a `StepDrive` (`motor.py`).  A part that sits on a shaft is a module of this
package whose class has the attribute `sits = "must"`: its rule is a `Sensor` (`sensors.py`), and its output is an
`EncoderChannel`, whose levels repeat with the count, or a `SwitchZone`, which is closed between two positions
(`shown.py`).  Shafts driven by another shaft are in `carriage.py`.
"""
