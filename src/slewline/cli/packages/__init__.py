"""Packages for a user's own chip or part, from templates: `slewline new-chip` and `slewline new-part`."""
