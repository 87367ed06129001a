"""Run scripts: what a host sends, line after line, and what it does in between."""
