"""The CY512: what it adds to the family, and where it differs from its sister chips."""
