"""The other end of served registers: for host programs in Python."""
