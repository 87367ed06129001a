"""What stands around a chip: host computers, loaders, gates, sensors.  Wired by nets, never by calls into a chip."""
