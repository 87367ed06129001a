"""Clients of served registers, for host programs in Python."""
