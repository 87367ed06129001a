"""Python clients of a slewline server: clients for served registers, and a client for the control port."""
