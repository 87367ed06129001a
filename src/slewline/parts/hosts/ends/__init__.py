"""The hosts' ends of their channels: bus ports, UARTs, and shadows of registers that cannot be read."""
