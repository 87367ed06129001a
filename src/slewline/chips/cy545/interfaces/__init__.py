"""Interfaces: parallel and serial side, local bus, display, user bits."""
