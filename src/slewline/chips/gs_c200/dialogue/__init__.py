"""What the host says and the program does: lines, commands, instructions, runs."""
