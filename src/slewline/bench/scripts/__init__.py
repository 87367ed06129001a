"""Run scripts: the commands of a host, line by line, and its actions between them.

A directive is a row in `directives.py`; `protocols.py` sends lines over each channel.
"""
