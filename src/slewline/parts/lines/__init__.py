"""Serial lines: connectors, a UART, and a noisy line."""
