"""Files of users: journals, bench files as text, images of memories.

A key of bench files is a row in `tables.py`, an entry of journals one in `entries.py`, played by `replaying.py`
above.
"""
