"""Options of the command line: their values, completion in a shell, and help."""
