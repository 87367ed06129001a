"""The drilling machine of the GS-C data sheet: one module feeds a bar, another drills it, user I/O links them."""

import slewline

FEED = "P S10 T100 R40 W1 +250 L0 A2 D1 C2 W2 +120 L4 A2 C2 W2 +250 A1 D5 C1 E"
DRILL = "P S15 T200 R25 L0 W1 W2 A2 +150 D1 G0 C2 A1 D1 C1 L5 E"  # as printed, plus a loop for the five holes
bench = slewline.Bench()
straps = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}  # 9600 baud, no checksum
units = [bench.add("gs-c200", name=name, straps=straps) for name in ("drill", "feed")]
bench.part("drill", name="spindle", to="drill")
bar = bench.part("bar", to="feed")
for pin, end in (("feed.uo2", "drill.ui2"), ("drill.uo1", "feed.ui2"), ("spindle.bit", "bar.bit")):
    bench.wire(pin, end)
for host, program in zip([bench.host(unit) for unit in units], (DRILL, FEED), strict=True):
    assert {host.ask(line) for line in program.split()} == {"Y"}
bench.run_until_idle()
print(*bar.pieces, f"{len(bench.chips['drill'].steps())} steps of the drill, idle at {bench.now:.3f} s", sep="\n")
