"""Measurements on recorded edges, and recordings compared with one another."""
