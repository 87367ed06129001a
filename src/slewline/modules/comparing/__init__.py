"""Comparison of a dialogue with the model, by replay in virtual time; playback of a dialogue to a module."""
