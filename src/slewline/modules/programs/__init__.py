"""The program of a real module: reading, sending, verifying, and saving it in files."""
