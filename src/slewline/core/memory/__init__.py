"""Memories: what is kept without power, and images of what a memory holds."""
