"""Two arms hand over a part: `-` makes DIRECTION and pin 34 both low for 30 µs, and U in the next arm catches it."""

import slewline

TAKE = "U\rP 0\r+\rC\rD 90\rP 14\rD 90\rP 108\r"
GIVE = "-\rP 122\rB\rD 90\rP 108\rD 90\rR 20\rP 0\rP 14\rR 120\rT 0\r0\r"
bench = slewline.Bench()
arms = [bench.add("cy525", name=name) for name in ("giver", "taker")]
bench.part("or", name="arrived")
for pin, gate in (("giver.direction", "in1"), ("giver.programmable_output", "in2"), ("taker.wait", "out")):
    bench.wire(pin, f"arrived.{gate}")
for arm in arms:
    bench.record(f"{arm.name}.motion_complete")
    bench.host(arm).send("A 0\rR 120\rS 25\rF 5\rZ 1\rP 14\rE\r" + TAKE + GIVE + "QX\r")
arms[0].pin("wait").pulse(0, "1 ms", at="200 ms")  # a part for the first arm
bench.run("3 s")
for arm in arms:
    times, levels = bench.edges(f"{arm.name}.motion_complete")
    print(*(f"{int(t) / 1e9:.1f} ms: {arm.name} at {arm.position_at(int(t))}" for t in times[levels == 0]), sep="\n")
