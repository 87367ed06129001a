"""Commands about motors: the fastest ramp, and the friction and iron loss, which no data sheet lists."""
