"""The GS-C200 and GS-C200S modules."""
