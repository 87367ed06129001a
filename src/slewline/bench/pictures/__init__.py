"""Recordings, pictures, files and timing diagrams of a bench.

`signals.py` selects the signals that are recorded.  A function that draws to a file checks the file extension first, as
`timing.py` does.
"""
