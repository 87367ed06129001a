"""The CY500: its additions to the CY5xx family, and its differences from the family."""
