"""Elements of messages to users: suggestions of names, reports about calls that do not fit, remedies.

A name that users expect in a class, but that does not exist, is a row of its `missing` (`instead.py`).  A message about
an unknown name lists the known ones and ends with `hint` (`near.py`).
"""
