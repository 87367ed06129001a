"""Interfaces between laboratory systems and a module: the module's motor as an EPICS motor record.

The motor is in `module_motor.py`, which finds the part's commands by their roles; an interface to
another laboratory system would be a further file in this folder.  The fields of the motor record are the
rows of `field_table.py`; a row names the method in `effects.py` that handles puts into its field, and
`record_state.py` computes the values.
"""
