"""The CY500: what it has beside the family, and where it differs."""
