"""What a bench records, draws and writes, and its timing diagrams."""
