"""The CY512: its additions to the family, and its differences."""
