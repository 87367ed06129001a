"""Comparison of a dialogue with the model, by replay in virtual time; or playback to a module."""
