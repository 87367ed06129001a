"""The CY512: its additions to the CY5xx family, and its differences from its sister chips."""
