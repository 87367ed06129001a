"""The front panel: displays, thumbwheels, a jog switch, a keyboard."""
