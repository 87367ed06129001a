"""Time: integer picoseconds, the event kernel with its tasks, and inputs from outside a run.

An event for listeners is a `Hook` (`hook.py`) named on_..., with a row in tests/system/test_hooks.py.  A method by
which a user acts on a chip or a part is declared `@from_outside` (`inputs.py`) and calls `self.input(verb, ...)`;
consequences of an input that was reported already are done `with outside.nested()` (`outside.py`).
"""
