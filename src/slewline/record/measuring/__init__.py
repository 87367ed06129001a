"""Measurements on recorded edges, and comparison of recordings."""
