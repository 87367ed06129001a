"""Stepper motors, simulated by their equations: motor, driver and load data, the law, and its integration.

A motor on the market is a row of `MOTORS` in `motors.py`, and a driver a row of `DRIVERS` in `drivers.py`, each with
its data sheet.  The behaviour of a motor, a driver or a load is a piece of `equations.py`; `law.py` contains its
parameters, and the conditions under which it applies.  Every engine runs these equations, and check 43 of
`make physics` compares their results bit for bit.
"""
