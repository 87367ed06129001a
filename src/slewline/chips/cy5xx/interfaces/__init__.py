"""The command port, what is read back over it, and the lines by their names."""
