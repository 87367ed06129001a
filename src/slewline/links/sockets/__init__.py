"""Sockets and descriptors: the loop that waits for them, streams, foreign protocols, and system differences.

All differences between operating systems are in `system.py`.
"""
