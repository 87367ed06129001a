"""The version of the project, which a journal names as well."""

__version__ = "0.1.0"
