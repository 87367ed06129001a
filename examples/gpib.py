"""A CY525 as a simple IEEE-488 listener; a BASIC controller sends a line feed after every carriage return."""

import slewline

bench = slewline.Bench()
x = bench.add("cy525", name="x")
bench.part("gpib_listener", name="gpib", to=x)
pet = bench.part("gpib_talker", name="pet", to="gpib")

pet.clear()
pet.send("C\r\nA 0\r\nF 10\r\nR 40\r\nS 200\r\nZ 1\r\nN 250\r\nG\r\n")
bench.run_until_idle()
print(f"position {x.position}, output {x.pin('programmable_output').level}, service requests {pet.requests}")
