"""Two latches capture the position while the motor turns; the host reads them later over the same bus."""

import slewline

bench = slewline.Bench()
x = bench.add("cy525", name="x")
latch = bench.part("position_latch", to=x)
host = bench.host(x)

host.send("A 60000\rF 10\rR 120\rS 250\rZ 1\rN 9000\rG\r")
for position in (61000, 65500, 1500):
    bench.run_until(x.reaches(position))
    read = host.read_position()
    print(f"read {read}, latched {latch.high_byte:02X} {latch.low_byte:02X}")
bench.run_until_idle()
print(f"at rest at {x.position}, latched {latch.position}")
