"""The panel from the command line: what it shows, and the process that it runs in."""
