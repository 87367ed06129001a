"""Options of the command line: what their values are, how a shell completes them, what help they give."""
