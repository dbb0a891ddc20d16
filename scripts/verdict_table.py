#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Verdicts of limber health on simulated rigs whose error is known, and the coverage of its 95 % intervals.

  scripts/verdict_table.py [--runs N] [--seed N] [--scenarios NAME,...] [--shapes NAME,...] [--limber PROGRAM] [--jobs N] [--details FILE]

Each run simulates a sound rig and assumes it wrong by shares of the tolerance, each on one axis in turn: 0 (sound), half of
what is ok (inside), between ok and wrong (between), twice what is wrong (outside). Automatic start, default options.
An axis is covered if its true error lies within 1.96 of the sigmas that limber states.

Shapes but `constant` bend the recording over time (limber decalibrate), inside and outside: `step` at 40 % of it, `ramp` over all of it,
`vibration` of 3.3 Hz (that amplitude), and `pulse`, from 30 to 60 %. Covered is the rig at the end of the
present state, `to_s` (of a vibration the mean).
"""
import argparse
import collections
import concurrent.futures
import json
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
AXES = ["ax", "ay", "az", "tx", "ty", "tz"]
SIZES = {"sound": lambda ok, wrong: 0.0, "inside": lambda ok, wrong: 0.5 * ok,
         "between": lambda ok, wrong: 0.5 * (ok + wrong), "outside": lambda ok, wrong: 2.0 * wrong}
UNITS = {"deg": 1.0, "mm": 1e-3}
VERDICTS = ["ok", "degraded", "decalibrated", "cannot tell"]


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def health(limber, recording, error):
    done = run(limber, "health", recording, "--json", *(["--assume-error", error] if error else []))
    if not done.stdout:
        raise SystemExit(f"{recording}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def error_of(axis, size, unit):
    """What to assume, so that true minus assumed is `size`."""
    return ",".join(f"{-size * UNITS[unit]:.9g}" if name == axis else "0" for name in AXES)


def profile(shape, axis, size, unit, duration):
    """A scenario that bends one axis by `size` over time."""
    amplitude = ", ".join(f"{size * (1.0 if unit == 'deg' else 1e-3):.9g}" if name == axis else "0" for name in AXES)
    keys = {"step": f"shape: steps, steps: [{{at: {0.4 * duration}, value: 1}}]",
            "ramp": f"shape: ramp, start: 0, end: {duration}",
            "vibration": "shape: vibration, frequency: 3.3",
            "pulse": f"shape: steps, steps: [{{at: {0.3 * duration}, value: 1}}, {{at: {0.6 * duration}, value: 0}}]"}
    return f"decalibration:\n  - {{{keys[shape]}, amplitude: [{amplitude}]}}\n"


class Tally:
    def __init__(self):
        self.verdicts = collections.Counter()
        self.covered = self.intervals = self.named = self.changed = self.mistakes = 0

    def add(self, found, truth, changed):
        self.verdicts[found["verdict"]] += 1
        self.mistakes += bool(found["mistakes"])
        if found["health"] is None:
            return
        present = found["health"]["present"]
        for name, axis in present["axes"].items():
            self.intervals += 1
            self.covered += abs(axis["error"] - truth.get(name, 0.0)) <= 1.96 * axis["sigma"]
        if changed:
            self.changed += 1
            self.named += present["most_likely_axis"] == changed

    def row(self):
        share = f"{100 * self.covered / self.intervals:.0f} %" if self.intervals else "–"
        named = f"{self.named} of {self.changed}" if self.changed else "–"
        return [*(str(self.verdicts[v]) for v in VERDICTS), share, named, str(self.mistakes)]


def judge_shapes(limber, recording, folder, shapes, name, sound):
    """A (rig, what health said, true error per axis, axis to be named) for each shape, inside and outside."""
    axis = sound["health"]["present"]["axes"][name]
    for shape in shapes:
        for level in ("inside", "outside"):
            size = SIZES[level](axis["ok"], axis["wrong"])
            scenario = folder / "profile.yaml"
            scenario.write_text(profile(shape, name, size, axis["unit"], sound["duration_s"]))
            bent = folder / f"{shape}_{level}"
            done = run(limber, "decalibrate", recording, "--as", scenario, "--out", bent)
            if done.returncode:
                raise SystemExit(f"{recording}: {done.stderr.strip()}")
            found = health(limber, bent, "")
            share = found["health"]["present"]["to_s"] / sound["duration_s"] if found["health"] else 0.0
            at_end = size * {"step": 1.0, "ramp": share}.get(shape, 0.0)
            yield f"{shape}, {level}", found, {name: at_end}, name if level == "outside" and shape != "pulse" else ""


def judge(limber, scenario, pixels, seed, shapes):
    """All judgements of one simulated rig, as judge_shapes gives them."""
    with tempfile.TemporaryDirectory() as folder:
        recording = pathlib.Path(folder) / "recording"
        run(limber, "simulate", ROOT / f"scenarios/{scenario}.yaml", "--seed", seed, "--pixels", pixels, "--out", recording)
        sound = health(limber, recording, "")
        judged = [("sound", sound, {}, "")]
        axes = sound["health"]["present"]["axes"]
        name = AXES[seed % 6]
        axis = axes[name]
        judged += judge_shapes(limber, recording, pathlib.Path(folder), [s for s in shapes if s != "constant"], name, sound)
        if "constant" not in shapes:
            return judged
        for level in ("inside", "between", "outside"):
            size = SIZES[level](axis["ok"], axis["wrong"])
            found = health(limber, recording, error_of(name, size, axis["unit"]))
            judged.append((level, found, {name: size}, name if level == "outside" else ""))
        return judged


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1, help="of the first run; the axis is that of seed modulo 6")
    parser.add_argument("--scenarios", default="paper_i,drone_none")
    parser.add_argument("--shapes", default="constant", help="constant, step, ramp, vibration, pulse")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--details", type=argparse.FileType("w"), help="one JSON object a line: every judgement")
    arguments = parser.parse_args()
    print("| scenario, pixels | rig | " + " | ".join(VERDICTS) + " | 95 % covers | axis named | mistakes claimed |")
    print("| --- " * 9 + "|")
    for scenario in arguments.scenarios.split(","):
        for pixels in ("white", "realistic"):
            tallies = collections.defaultdict(Tally)
            seeds = range(arguments.seed, arguments.seed + arguments.runs)
            with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
                runs = pool.map(lambda seed: judge(arguments.limber, scenario, pixels, seed, arguments.shapes.split(",")), seeds)
                for seed, judged in zip(seeds, runs):
                    for level, found, truth, changed in judged:
                        tallies[level].add(found, truth, changed)
                        if arguments.details:
                            print(json.dumps({"scenario": scenario, "pixels": pixels, "seed": seed, "rig": level, "truth": truth, "found": found}),
                                  file=arguments.details, flush=True)
            for level, tally in tallies.items():
                print(f"| {scenario}, {pixels} | {level} | " + " | ".join(tally.row()) + " |", flush=True)


if __name__ == "__main__":
    main()
