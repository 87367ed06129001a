"""Time: integer picoseconds, the event kernel with its tasks, and external inputs to a run.

An event for listeners is a `Hook` (`hook.py`) named on_..., with a row in tests/system/test_hooks.py.  A method with
which a user operates a chip or a part is declared with `@from_outside` (`inputs.py`) and calls `self.input(verb, ...)`;
the consequences of an already reported input are run inside `with outside.nested()` (`outside.py`).
"""
