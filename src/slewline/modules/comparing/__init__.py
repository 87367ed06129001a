"""Comparison of a dialogue with the model: exchanges, a replay in virtual time, differences; or playing to a module."""
