"""The command port, its read-out, and the lines by their names."""
