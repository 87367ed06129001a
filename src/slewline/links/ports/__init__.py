"""Ports on which the outside finds the modules: TCP, ptys, real serial ports, RFC 2217, registers."""
