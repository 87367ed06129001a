"""The CY500: its additions to the family, and its differences."""
