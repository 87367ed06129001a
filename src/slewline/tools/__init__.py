"""The command line.  Its modules load click and nothing heavy; what a command needs, it loads when it runs."""
