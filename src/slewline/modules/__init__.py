"""Real modules on a serial port: their dialogues, their backups, and their differences from the model.

The protocol of a part on a real port follows from its sheet: `channels`, the dialect (`questions`, `refusals`),
`starts` and the roles of its rows, `verify_bytes` of a part on a bus.  A channel of another kind needs a class
next to `adapter.py`.
"""
