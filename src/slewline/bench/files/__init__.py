"""User files: journals, bench files as text, memory images.

Each key of a bench file is a row in `tables.py`; each kind of journal entry is a row in `entries.py`, and is replayed
by `replaying.py` in the parent folder.
"""
