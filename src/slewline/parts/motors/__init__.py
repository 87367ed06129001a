"""Stepper motors by their equations: the data of motors, drivers and loads, their law, and its integration.

A motor on the market is a row of `MOTORS` in `motors.py`, a driver a row of `DRIVERS` in `drivers.py`, with its data
sheet.  The behaviour of a motor, a driver or a load is a piece of `equations.py`; its parameters, and where it
applies, are in `law.py`.  Every engine runs these equations, and check 43 of `make physics` compares their results
bit for bit.
"""
