"""Whole machines: a welder and a drill."""
