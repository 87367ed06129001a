"""The command port, its read-out, and access to lines by name."""
