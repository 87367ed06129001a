"""Serial lines: connectors, a UART, and a line with noise."""
