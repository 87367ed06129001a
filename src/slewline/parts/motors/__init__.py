"""Stepper motors, simulated by their equations of motion: data of motors, drivers and loads, and the integration.

A motor on the market is a row of `MOTORS` in `motors.py`, and a driver on the market a row of `DRIVERS`
in `drivers.py`; each row names its data sheet.  The behaviour of a motor, a driver or a load is a piece
of `equations.py`; `law.py` selects the pieces that apply, and computes their parameters.  Every engine
runs these equations, and check 43 of `make physics` compares the results of the engines bit for bit.
"""
