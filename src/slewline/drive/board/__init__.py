"""The board: the messages between host and board, its clock, its port, and its software twin.

Every board that uses these messages is a row of `BOARDS` in `boards.py`: its pins, limits and times.
Each message has a row in `FrameKind`, a definition of its fields and, if its size is fixed, an entry in
`SIZES`; all of these are in `wire.py`.  The effect of a message is in `twin_board.py` and in
firmware/uno; tests/firmware compares the twin and the firmware, cycle by cycle.
"""
