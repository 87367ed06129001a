"""Commands about motors: the fastest ramp, and constants that no data sheet lists."""
