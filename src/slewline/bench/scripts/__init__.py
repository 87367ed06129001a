"""Run scripts: what a host sends, line after line, and what it does in between.

A directive is a row in `directives.py`; what a line means to a host is in `protocols.py`, by the channel.
"""
