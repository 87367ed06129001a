"""Memories on a chip's bus, and a PROM that replaces a host.

A part that a chip reads on its local bus has a `BusInterface` (`external.py`).
"""
