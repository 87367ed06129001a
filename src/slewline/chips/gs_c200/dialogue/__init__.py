"""The dialogue with the host and the execution of the program: lines, commands, instructions, runs."""
