"""Commands for a real module on a serial port."""
