"""The pure part of the package: integers in, waveforms out.  No wall clock, no file, no socket, no thread.

It contains the base of all chips (`chip.py`), the base of chips and parts (`component.py`), the interface of a chip for
the objects inside it (`context.py`), and stored programs as users see them (`program.py`).
"""
