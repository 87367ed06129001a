"""Sockets and descriptors: the loop that waits for them, streams, strangers, and what systems lack."""
