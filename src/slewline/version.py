"""The version of the project, which journals also record."""

__version__ = "0.1.0"
