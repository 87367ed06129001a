"""The control port, its requests, and what it tells of a server."""
