"""Stepping: the plan player, the position counter, the lines to the driver."""
