"""The pure part of the package: integers in, waveforms out.  No wall clock, no file, no socket, no thread.

It contains the base of all chips (`chip.py`), the base that chips and parts share (`component.py`), the
interface of a chip for the objects in it (`context.py`), and stored programs as users see them
(`program.py`).
"""
