"""The hosts' ends of their channels: bus ports, UARTs, shadows of chip registers that hosts cannot read."""
