"""The program of a real module: read, sent, verified, saved in files."""
