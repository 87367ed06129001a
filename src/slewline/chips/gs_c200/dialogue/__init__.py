"""The dialogue with the host and program execution: lines, commands, instructions, runs."""
