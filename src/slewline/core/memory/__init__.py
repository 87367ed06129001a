"""Non-volatile memories, and images of their content."""
