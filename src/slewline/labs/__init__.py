"""Interfaces of laboratory systems to a module: its motor, as a record of EPICS.

The motor is `module_motor.py`, which finds its commands by their roles; the interface of another laboratory system is a
file here.  The fields of the motor record are the rows of `field_table.py`; the method of `effects.py` that a row names
handles puts, and `record_state.py` computes the values.
"""
