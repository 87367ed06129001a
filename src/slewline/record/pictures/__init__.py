"""Pictures: figures of motions, lanes of pins, timing diagrams."""
