"""Time: integer picoseconds, the event kernel with its tasks, and what comes from outside a run."""
