"""Files that a user names: journals, bench files as they are read, images of memories."""
