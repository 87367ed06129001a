"""Elements of user messages: name suggestions, reports about calls with wrong arguments, remedies.

A name that users expect in a class, but that the class does not have, is listed in a call of `missing`
for that class (`instead.py`).  A message about an unknown name lists the known names and ends with the
text that `hint` returns (`near.py`).
"""
