"""Ends of hosts on their channels: ports of a bus, UARTs of a line, shadows of registers that cannot be read."""
