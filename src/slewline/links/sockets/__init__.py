"""Sockets and descriptors: the loop that waits for them, streams, foreign protocols, and operating-system differences.

All differences between operating systems are in `system.py`.
"""
