"""Time: integer picoseconds, the event kernel with its tasks, and external inputs to a run.

An event for listeners is a `Hook` (`hook.py`) named on_..., with a row in tests/system/test_hooks.py.  A method with
which a user operates a chip or a part is declared with `@from_outside` (`inputs.py`) and calls `self.input(verb, ...)`;
consequences of an input that has already been reported run inside `with outside.nested()` (`outside.py`).
"""
