"""A noisy RS-232 line: the module answers a parity error with E1, and the host repeats the command."""

import slewline

bench = slewline.Bench()
x = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0})  # 9600 baud, checksum on
line = bench.part("rs232_line", name="line")
host = bench.host(x, line=line)
line.plan("to_module", "garbled", count=1000, chance=0.1, seed=7)
tries = 0
for command in ["Po", "S10", "T100", "R10", "L0", "+200", "-200", "L5", "Px"]:
    while True:
        tries += 1
        try:
            if host.ask(command, timeout="100 ms") == "Y":
                break
        except slewline.Timeout:  # the carriage return was corrupted
            pass
print(f"{tries} tries, {line.way('to_module').noise.done['garbled']} bits inverted", x.listing(), sep="\n")
