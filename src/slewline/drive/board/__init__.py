"""The board: the messages between host and board, its clock, its port, and its software twin.

Every board that uses these messages is a row of `BOARDS` in `boards.py`: its pins, limits and times.  A
message is a row of `FrameKind`, a size in `SIZES` and its fields in `wire.py`; its effect is in
`twin_board.py` and in firmware/uno, and tests/firmware compares the twin and the firmware, cycle by
cycle.
"""
