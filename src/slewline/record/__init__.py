"""Observers of nets: recorder, measurements, VCD, CSV, NPZ and plots.  They only read levels.

Importing any of these modules loads neither NumPy nor matplotlib; the functions that need these packages
load them when called.
"""
