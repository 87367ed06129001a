"""A host computer sets up a CY525, moves the motor, and reads back the position."""

import slewline

bench = slewline.Bench()
x = bench.add("cy525", name="x", crystal="11 MHz")
host = bench.host(x, delay="100 us")  # the time its program takes before each byte

host.send("A 0\rR 100\rF 10\rS 250\rZ 1\rN 5000\rG\r")
bench.run_until(x.reaches(2500))
print(f"halfway at {bench.now:.3f} s, SLEW is {x.pin('slew').level}")
bench.run_until_idle()
print(f"{len(x.steps())} steps, position {host.verify(0).decode()}, parameters {host.verify(3).hex(' ')}")
