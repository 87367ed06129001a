"""The command line.  Its modules load click and nothing heavy; what a command needs, it loads when it runs."""

FOUND, WRONG_USE = 1, 2  # exit status; 0: all is well
