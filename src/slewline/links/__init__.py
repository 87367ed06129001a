"""Where virtual time meets the world: sockets, serial ports, the wall clock, files that keep memories."""
