"""Packages with a chip or a part of one's own, from templates: `slewline new-chip` and `slewline new-part`."""
