"""Ports through which hosts reach the modules: TCP, ptys, real serial ports, RFC 2217, registers.

A new protocol for hosts on a bus port needs a line class like that in `prologix.py`; if each request has an
answer, derive the class from `RequestLine` (links/lines/request_line.py).
"""
