"""Interfaces between laboratory systems and a module: the module's motor as an EPICS motor record.

The motor is in `module_motor.py`, which finds its commands by their roles; an interface to another
laboratory system is a file here.  The fields of the motor record are the rows of `field_table.py`; a row
names the method in `effects.py` that handles puts into its field, and `record_state.py` computes the
values.
"""
