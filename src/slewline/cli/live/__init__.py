"""Commands that run until they are stopped (serve, panel, debug), and the processes that they start."""
