"""Elements of user messages: name suggestions, reports about calls with wrong arguments, remedies.

A name that users expect in a class, but that does not exist, is listed in a call of `missing` for that
class (`instead.py`).  A message about an unknown name lists the known ones and ends with `hint`
(`near.py`).
"""
