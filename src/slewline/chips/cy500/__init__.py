"""The CY500: what it adds to the family, and where it differs from the family."""
