"""Two CY525s start together: pin 34 of the master drives WAIT of the slave (manual, section 10)."""

import slewline

SET_UP = "A 0\rF 10\rR 80\rS 240\rZ 1\rN 500\r"
bench = slewline.Bench()
master, slave = (bench.add("cy525", name=name) for name in ("master", "slave"))
bench.wire("master.programmable_output", "slave.wait")
bench.host(slave).send(SET_UP + "E\rU\rG\r0\rQX\r")
host = bench.host(master)
host.send(SET_UP + "E\rC\rG\r0\rQ")
bench.run("1 s")
print(slave.waiting)
host.send("X\r")
bench.run_until_idle()
apart = slave.steps().times_ps - master.steps().times_ps
print(f"positions {master.position} and {slave.position}, apart by {apart.min() / 1e6} to {apart.max() / 1e6} µs")
