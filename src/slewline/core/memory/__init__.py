"""Non-volatile memories and memory images."""
