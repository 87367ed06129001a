"""What messages to users are made of: names that were meant, calls that do not fit, what to write instead.

A name that a class does not have, but readers look for, is a row of its `missing` (`instead.py`).  A message about an
unknown name lists the known ones and ends with `hint` (`near.py`).
"""
