"""Ports on which the outside finds the modules: TCP, ptys, real serial ports, RFC 2217, registers.

Another way for host software to speak on the port of a bus is a line like that of `prologix.py`; if each request has
its answer, it is a `RequestLine` (links/lines/request_line.py).
"""
