#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How often the intervals of limber compare hold: the table of docs/evidence/compare.md.

  scripts/compare_table.py [--runs N] [--seed N] [--methods A,B] [--scenarios NAME,...] [--out DIR]

Each scenario is recorded N times with other noise, and run with both methods. What the interval of one recording should hold
is the mean difference of all N.
"""
import argparse
import json
import pathlib
import shutil
import statistics
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent


def limber(arguments, *words):
    done = subprocess.run([arguments.limber, *words], check=True, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL)
    return done.stdout


def differences(arguments, scenario):
    """Of every recording: [rpe_percent, rpe_deg] as limber compare --json has them."""
    out = []
    for seed in range(arguments.seed, arguments.seed + arguments.runs):
        folder = arguments.out / f"{scenario}_{seed}"
        shutil.rmtree(folder, ignore_errors=True)
        limber(arguments, "simulate", ROOT / f"scenarios/{scenario}.yaml", "--seed", str(seed), "--out", folder / "log")
        try:
            limber(arguments, "run", folder / "log", "--methods", arguments.methods, "--out", folder / "runs")
            comparison = json.loads(limber(arguments, "compare", *(folder / "runs" / name for name in arguments.methods.split(",")), "--json"))
            out.append([comparison["differences"][0][key] for key in ("rpe_percent", "rpe_deg")])
        except subprocess.CalledProcessError:
            print(f"{scenario}, seed {seed}: a run failed", flush=True)
        shutil.rmtree(folder)
    return out


def cell(found):
    mean = statistics.mean(d["mean"] for d in found)
    known = [d for d in found if d["low"] is not None]
    held = sum(d["low"] <= mean <= d["high"] for d in known)
    sign = "worse" if mean > 0 else "better"
    said = {word: sum(d["judgement"] == word for d in found) for word in ("better", "worse", "cannot tell")}
    wrong = sum(number for word, number in said.items() if word not in (sign, "cannot tell"))
    return f"{mean:+.3f} | {held} of {len(known)} | {said[sign]} {sign}, {said['cannot tell']} cannot tell, {wrong} wrong"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--methods", default="ekf,lcekf")
    parser.add_argument("--scenarios", default="drone_none,drone_constant")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results/compare")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    print("| scenario | error | mean difference | interval holds it | said |")
    print("| --- | --- | --- | --- | --- |")
    for scenario in arguments.scenarios.split(","):
        found = differences(arguments, scenario)
        for k, name in enumerate(("RPE [%]", "RPE [deg a piece]")):
            if found:
                print(f"| {scenario} | {name} | {cell([pair[k] for pair in found])} |", flush=True)


if __name__ == "__main__":
    main()
