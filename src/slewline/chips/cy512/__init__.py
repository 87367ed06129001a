"""The CY512: its additions to the family, and where it differs from its sister chips."""
