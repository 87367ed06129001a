"""Data sheets as data: pins, commands, registers, times, options, channels, quirks; how parts are found by name."""
