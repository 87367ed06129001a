"""Ports through which hosts reach the modules: TCP, ptys, real serial ports, RFC 2217, registers.

A new protocol for hosts on a bus port is a line like that in `prologix.py`; if each request has an answer, it is a
`RequestLine` (links/lines/request_line.py).
"""
