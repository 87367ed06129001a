"""The pure part of the house: integers in, waveforms out.  No wall clock, no file, no socket, no thread.

Here are what a bench asks of every chip (`chip.py`), what chips and parts have in common (`component.py`), what the
objects inside a chip may use of it (`context.py`), and stored programs as users see them (`program.py`).
"""
