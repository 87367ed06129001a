"""Stand-alone operation: a PROM loads a program that moves back and forth; a high DOWHILE ends it."""

import slewline

PROGRAM = "A 0\rF 10\rR 60\rS 240\rZ 1\rE\rN 400\r+\rG\r-\rG\rT 0\r0\rQX\r"

bench = slewline.Bench()
x = bench.add("cy525", name="x")
prom = bench.part("prom", to=x, image=PROGRAM)
x.pin("dowhile").drive(0)

bench.run("1 s")
print(f"{prom.address} of {len(PROGRAM)} bytes, program {x.program.hex(' ')}, RUN {x.pin('run').level}")
x.pin("dowhile").drive(1)
bench.run_until_idle()
print(f"{len(x.steps())} steps, position {x.position}, RUN {x.pin('run').level}, {prom.waiting}")
