"""Observers of nets: recorder, measurements, VCD, CSV, NPZ and plots.  They read and never change a level.

Importing any of these modules loads neither NumPy nor matplotlib; the functions that need them do.
"""
