"""The phase current of a motor: high on ramps, lower at speed, lowest at standstill; MOV and RAMP select it."""

import slewline

bench = slewline.Bench()
x = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
current = bench.part("phase_current", to=x)  # with the resistor values of the data sheet
host = bench.host(x)
for line in ["Po", "S10", "T100", "R50", "+1000", "E"]:
    host.ask(line)
bench.run_until_idle()
for ps, amperes in current.past:
    print(f"from {ps / 1e9:8.2f} ms  {amperes:.2f} A  at {x.position_at(ps):4}")
