"""Real modules on a serial port: their dialogues, their backups, and how they differ from the model.

How a part is spoken to over a real port follows from its sheet: `channels`, the dialect (`questions`, `refusals`),
`starts` and the roles of its rows, `verify_bytes` of a part on a bus.  For a channel of another kind there is a class
next to `adapter.py`.
"""
