"""The welding machine of the manual, section 4, with workpieces, carriage and torch around the chip."""

import slewline

SET_UP = "C\rA 0\rF 3\rR 80\rS 200\rZ 1\r"
PROGRAM = "E\rB$W\r+\rN 100\rC$B\rD 500\rC\rG\rL 6,C\rP 0\rT B\r0\rQX\r"

bench = slewline.Bench()
x = bench.add("cy525", name="x")
pieces = bench.part("workpieces", to=x, pieces=2, change="1 s")
welder = bench.part("welder", to=x)
bench.host(x).send(SET_UP + PROGRAM)
bench.run_until_idle()
print(pieces.waiting, "at", bench.now)
print(*welder.spots[1:], sep="\n")  # without the first: the torch is on from reset until C
