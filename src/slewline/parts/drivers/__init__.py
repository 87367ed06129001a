"""Driver modules, and the circuits between them and a GS-C controller module."""
