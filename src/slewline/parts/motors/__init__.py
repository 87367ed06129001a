"""Stepper motors by their equations: data of motors, drivers and loads, the law they follow, and its integration.

A motor that can be bought is a row of `MOTORS` in `motors.py`, a driver one of `DRIVERS` in `drivers.py`, with the
data sheet that it is from.  What a motor, a driver or a load does is a piece of `equations.py`; its parameters, and
where it applies, are in `law.py`.  Every engine runs it from there, and check 43 of `make physics` compares their
bits.
"""
