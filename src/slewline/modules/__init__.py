"""Real modules on a serial port: their dialogues, their backups, and their differences from the model.

The protocol of a part on a real port follows from its sheet: `channels`, the dialect (`questions`,
`refusals`), `starts`, the roles of its rows, and `verify_bytes` for a part on a bus.  A channel of
another kind needs a class like the one in `adapter.py`.
"""
