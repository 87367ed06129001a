"""Commands about motors: the fastest ramp, and the constants that no data sheet lists."""
