"""The pure part of the package: integers in, waveforms out.  No wall clock, no file, no socket, no thread.

This part contains the base of all chips (`chip.py`), the base of chips and parts (`component.py`), the
interface of a chip for the objects in it (`context.py`), and stored programs for users (`program.py`).
"""
