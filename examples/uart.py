"""A serial line with a receive-only UART: it cannot hold the host off, so characters are lost during a move."""

import slewline

bench = slewline.Bench()
x = bench.add("cy525", name="x")
bench.part("uart", to=x, baud=9600, parity="even")
pc = bench.part("serial_sender", name="pc", to="uart", baud=9600, parity="even")

pc.send("A 0\rF 20\rR 20\rS 255\rZ 1\rN 100\rG\rC\r")  # the C arrives during the move
bench.run_until_idle()
print(x.position, x.pin("programmable_output").level)
pc.send("P 0\r")
pc.pause("100 ms")  # this time the host waits
pc.send("C\r")
bench.run_until_idle()
print(x.position, x.pin("programmable_output").level, *bench.findings, sep="\n")
