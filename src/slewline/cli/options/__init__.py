"""Options of the command line: their values, their completion in a shell, and their help."""
