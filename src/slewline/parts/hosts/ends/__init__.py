"""The ends of hosts on their channels: ports of a bus, UARTs of a line, shadows of what cannot be read."""
