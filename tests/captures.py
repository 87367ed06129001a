"""Recordings of a known wave in the forms in which analysers and oscilloscopes write them.

The wave is exact; a recording samples it as an instrument does: at a rate, with a phase, and only what is longer than a
sample is seen for certain.  What each instrument writes was seen in its files; nothing here is written by our own code.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np

US, MS, S = 10**6, 10**9, 10**12
HIGH = 5 * US  # of a pulse
FORWARD, BACK = 120, 70  # steps


@dataclass
class Wave:
    """Edges of signals by name: ascending times (ps), and the level before the first; each edge changes the level."""

    edges: dict[str, list[int]]
    first: dict[str, int]
    end: int

    def levels_at(self, name: str, times: np.ndarray) -> np.ndarray:
        return (np.searchsorted(self.edges[name], times, side="right") + self.first[name]) % 2

    def inverted(self, *names: str) -> Wave:
        return Wave(self.edges, {name: level ^ (name in names) for name, level in self.first.items()}, self.end)

    def swapped(self, one: str, other: str) -> Wave:
        names = {one: other, other: one}
        return Wave(
            {name: self.edges[names.get(name, name)] for name in self.edges},
            {name: self.first[names.get(name, name)] for name in self.first},
            self.end,
        )

    def delayed(self, name: str, by: int) -> Wave:
        return Wave({**self.edges, name: [at + by for at in self.edges[name]]}, self.first, self.end)

    def jittered(self, by: int, seed: int) -> Wave:
        """STEP with a jitter of up to `by` to both sides; its pulses keep their width."""
        chance = np.random.default_rng(seed)
        off = chance.integers(-by, by + 1, len(self.edges["STEP"]) // 2).repeat(2)
        return Wave({**self.edges, "STEP": (np.array(self.edges["STEP"]) + off).tolist()}, self.first, self.end)


def wave() -> Wave:
    """Steps of a ramp, a plateau and a ramp, forward and then back; DIR changes 20 µs before the first step."""
    at, edges, turn = 1_234_567_891, [], 0
    for steps in (FORWARD, BACK):
        turn = at
        at += 20 * US
        for n in range(steps):
            edges += [at, at + HIGH]
            at += int(S / (2000 + 60 * min(n, steps - 1 - n, 40)))
        at += 3 * MS
    return Wave({"STEP": edges, "DIR": [1_200_000_000, turn]}, {"STEP": 0, "DIR": 0}, at)


def model(of: Wave, path: Path) -> Path:
    """The wave as our own program would write it: exact, to the nanosecond."""
    lines = ["$timescale 1 ns $end", "$version slewline $end", "$scope module x $end"]
    lines += [f"$var wire 1 {code} {name} $end" for code, name in zip("!%", of.edges, strict=True)]
    lines += ["$upscope $end", "$enddefinitions $end"]
    path.write_text("\n".join([*lines, *_changes(of, lambda at: at // 1000, 1)]) + "\n")
    return path


def _changes(of: Wave, unit: Callable[[int], int], values: int) -> Iterable[str]:
    codes = dict(zip(of.edges, "!%", strict=True))
    found: dict[int, list[str]] = {0: [f"{of.first[name]}{code}" for name, code in codes.items()] if values else []}
    for name, code in codes.items():
        for n, at in enumerate(of.edges[name], 1):
            found.setdefault(unit(at), []).append(f"{(of.first[name] + n) % 2}{code}")
    return [f"#{at} {' '.join(found[at])}" for at in sorted(found)]


# ------------------------------------------------------------------------------------------------------------- sampled
@dataclass
class Sampled:
    """What an instrument has seen: sample numbers of edges, by name; at a rate (Hz)."""

    of: Wave
    rate: int
    phase: float = 0.37  # of a sample
    edges: dict[str, list[int]] = field(init=False)

    def __post_init__(self) -> None:
        period = Fraction(S, self.rate)
        self.edges = {name: [int(-(-(at - self.phase * period) // period)) for at in times]
                      for name, times in self.of.edges.items()}  # fmt: skip

    @property
    def count(self) -> int:
        return int(self.of.end * self.rate // S) + 2

    def ps(self, sample: int) -> Fraction:
        return Fraction(sample * S, self.rate)

    def changes(self) -> list[tuple[int, dict[str, int]]]:
        """All levels, at the first sample and at every change."""
        at = sorted({0, *(n for edges in self.edges.values() for n in edges)})
        levels = {name: [(sum(e <= n for e in edges) + self.of.first[name]) % 2 for n in at]
                  for name, edges in self.edges.items()}  # fmt: skip
        return [(n, {name: row[place] for name, row in levels.items()}) for place, n in enumerate(at)]

    def matrix(self) -> np.ndarray:
        """Every sample: (n, signals)."""
        places = np.arange(self.count)
        return np.stack([(np.searchsorted(edges, places, side="right") + self.of.first[name]) % 2
                         for name, edges in self.edges.items()], axis=1)  # fmt: skip


def sigrok_vcd(seen: Sampled, *, comment: bool = True, first: bool = True, bom: bool = False, end: str = "\n") -> bytes:
    """VCD as libsigrok writes it: a unit that is finer than the period, all levels at #0."""
    unit, name = (1000, "1 ns") if seen.rate in (8_000_000,) else (100, "100 ps")
    if S % seen.rate == 0 and S // seen.rate >= 100_000 and seen.rate <= 4_000_000:
        unit, name = {1: (US, "1 us"), 2: (100_000, "100 ns"), 4: (10_000, "10 ns")}[seen.rate // 1_000_000]
    lines = ["$date Sat Nov 28 10:00:00 2026 $end", "$version libsigrok 0.5.2 $end"]
    if comment:
        lines += ["$comment", f"  Acquisition with 2/8 channels at {seen.rate / 1e6:g} MHz", "$end"]
    lines += [f"$timescale {name} $end", "$scope module libsigrok $end"]
    lines += [f"$var wire 1 {code} {signal} $end" for code, signal in zip("!%", seen.edges, strict=True)]
    lines += ["$upscope $end", "$enddefinitions $end"]
    before: dict[str, int] = {} if first else dict(seen.of.first)
    for at, levels in seen.changes():
        told = [f"{level}{code}" for (signal, level), code in zip(levels.items(), "!%", strict=True)
                if before.get(signal) != level]  # fmt: skip
        before = levels
        lines.append(f"#{round(seen.ps(at) / unit)} {' '.join(told)}")
    return (b"\xef\xbb\xbf" if bom else b"") + (end.join(lines) + end).encode()


def saleae_csv(seen: Sampled, trigger_ps: int = 0) -> bytes:
    """What Logic 2 exports: changes, with times in seconds from the trigger on."""
    rows = [f"{float(seen.ps(at) - trigger_ps) / 1e12:.9f},{','.join(map(str, levels.values()))}"
            for at, levels in seen.changes()]  # fmt: skip
    return "\r\n".join([f"Time [s],{','.join(seen.edges)}", *rows, ""]).encode()


def dsview_csv(seen: Sampled) -> bytes:
    """What DSView exports: comments, and changes."""
    rows = [f"{float(seen.ps(at)) / 1e12:.10f},{','.join(map(str, levels.values()))}" for at, levels in seen.changes()]
    head = ["; CSV, generated by libsigrok4DSL 0.2.0 on Sat Nov 28 10:00:00 2026", "; Channels (2/16)",
            f"; Sample rate: {seen.rate / 1e6:g} MHz", "; Sample count: 1 M Samples"]  # fmt: skip
    return "\n".join([*head, f"Time(s),{','.join(seen.edges)}", *rows, ""]).encode()


def scope_csv(seen: Sampled, form: str, volts: float = 3.3, noise: float = 0.08, seed: int = 1) -> bytes:
    """What oscilloscopes write: every sample, in volts, with noise and slopes of a sample."""
    chance = np.random.default_rng(seed)
    levels = seen.matrix().astype(float)
    shown = volts * levels + chance.normal(0, noise, levels.shape).clip(-3 * noise, 3 * noise)
    names, step = list(seen.edges), 1 / seen.rate
    if form == "rigol":
        head = [f"X,{','.join(names)},Start,Increment,", f"Sequence,Volt,Volt,0.000000e+00,{step:.6e}"]
        rows = [f"{n},{a:.2e},{b:.2e},," for n, (a, b) in enumerate(shown)]
    elif form == "keysight":
        head = [f"x-axis,{','.join(names)}", "second,Volt,Volt"]
        rows = [f"{n * step - 0.001:+.9E},{a:+.4E},{b:+.4E}" for n, (a, b) in enumerate(shown)]
    elif form == "siglent":  # the names stand above those of the columns
        head = ["Record Length,Analog:5", f"Sample Interval,Analog:{step:.6e}", f"Source,{','.join(names)}",
                "Second,Value,Value"]  # fmt: skip
        rows = [f"{n * step - 0.001:.10f}, {a:.5f}, {b:.5f}" for n, (a, b) in enumerate(shown)]
    elif form == "tektronix":  # the head beside the first rows; one signal a file, here a second one after it
        said = ["Record Length,2.5e+03,", f"Sample Interval,{step:.6e},", "Trigger Point,1.25e+03,Samples",
                f"Source,{','.join(names)}"]  # fmt: skip
        head, said = [], said + [",,"] * (len(shown) - len(said))
        rows = [f"{before},{n * step - 0.001:.12f},  {a:.5f},{b:.5f}," for n, (before, (a, b)) in
                enumerate(zip(said, shown, strict=True))]  # fmt: skip
    elif form == "bare":  # numbers alone
        head, rows = [], [f"{n * step:.7E},{a:.5E},{b:.5E}" for n, (a, b) in enumerate(shown)]
    elif form == "waveforms":
        head = [
            "#Digilent WaveForms Oscilloscope Acquisition",
            "#Device Name: X",
            "",
            f"Time (s),{names[0]} (V),{names[1]} (V)",
        ]
        rows = [f"{n * step - 0.001:.12f},{a:.14f},{b:.14f}" for n, (a, b) in enumerate(shown)]
    else:  # with a decimal comma
        head = [f"Time;{';'.join(names)}", "(ms);(V);(V)", ""]
        rows = [f"{n * step * 1e3:.6f};{a:.4f};{b:.4f}".replace(".", ",") for n, (a, b) in enumerate(shown)]
    return "\r\n".join([*head, *rows, ""]).encode()


# ------------------------------------------------------------------------------------------------ by sigrok-cli itself
def sigrok_session(seen: Sampled, program: str, path: Path) -> Path:
    """A session (.sr), which sigrok-cli has made of the samples."""
    raw = path.with_suffix(".bin")
    raw.write_bytes((seen.matrix() @ np.array([1, 2])).astype(np.uint8).tobytes())
    form = f"binary:numchannels=2:samplerate={seen.rate}"
    subprocess.run([program, "-I", form, "-i", raw, "-O", "srzip", "-o", path], check=True, timeout=60)
    return path


def sigrok_converted(session: Path, program: str, form: str) -> bytes:
    """What sigrok-cli writes in one of its formats."""
    return subprocess.run([program, "-i", session, "-O", form], check=True, capture_output=True, timeout=60).stdout
