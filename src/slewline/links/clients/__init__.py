"""Clients of a slewline server, for programs in Python: for served registers and for the control port."""
