"""The history of nets: recording it, reducing it for pictures, and writing it to files as columns."""
