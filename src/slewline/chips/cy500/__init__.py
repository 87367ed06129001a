"""The CY500: its additions to the family, and where it differs from the family."""
