"""The command line.  A module of this package loads click and nothing heavy; what a command needs, it loads when it runs."""
