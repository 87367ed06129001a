"""Closed loop through ENABLE: each step waits until the motor has completed the previous one."""

import slewline

for closed in (False, True):
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    motor = bench.part("motor", to=x, lag="3 ms")  # a step takes 3 ms; a pulse in that time is lost
    if closed:
        bench.part("step_check", name="check", to=x)
        bench.wire("motor.x", "check.x")
        bench.wire("motor.y", "check.y")
    host = bench.host(x)
    for line in ["Po", "S10", "T100", "R10", "+200", "E"]:
        host.ask(line)
    bench.run_until_idle()
    print(f"{'closed' if closed else 'open'}: {host.ask('V1')}, motor at {motor.position}, {bench.now:.3f} s")
