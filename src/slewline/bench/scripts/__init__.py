"""Run scripts: the commands of a host, line by line, and its actions between them.

Each directive is a row in `directives.py`; `protocols.py` sends the lines over each kind of channel.
"""
