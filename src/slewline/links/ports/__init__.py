"""Ports through which hosts reach the modules: TCP, ptys, real serial ports, RFC 2217, registers.

A new protocol for hosts on the port of a bus is a line like that of `prologix.py`; if each request has an answer, it is
a `RequestLine` (links/lines/request_line.py).
"""
