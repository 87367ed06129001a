"""Three CY525s on one data bus: I/O REQUEST selects the chip that the host addresses."""

import slewline

bench = slewline.Bench()
chips = [bench.add("cy525", name=name) for name in ("x", "y", "z")]
host = bench.host(*chips)

for steps, chip in zip((1000, 200, 30), chips, strict=True):
    host.to(chip.name).send(f"A 0\rF 10\rR 80\rS 240\rZ 1\rN {steps}\rG\r")
for chip in reversed(chips):
    bench.run_until(chip.pin("motion_complete").is_(0))
    print(f"{chip.name} reaches {chip.position} at {bench.now}")
