#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How often limber health sees a change of a simulated rig that does not change, against the rate that is asked for.

  scripts/change_rate_table.py [--hours H] [--rate R] [--seed N] [--seconds S] [--scenario NAME] [--pixels KIND] [--tolerances NAME,...] [--limber PROGRAM] [--details FILE]

Simulates sound rigs, S seconds each, until there are H hours, and counts the changes that `--false-alarms R` lets through:
with the `default` tolerance, where a change also has to be half of what is ok, and with one so small that `chance` alone
decides. The interval is that of Poisson's distribution, 95 %. Ended by Ctrl-C, it gives the table of what there is.
"""
import argparse
import json
import math
import pathlib
import tempfile

from verdict_table import ROOT, run

TOLERANCES = {"default": [], "chance": ["--tolerance", "px=0.001:1,depth=0.01:10"]}


def poisson_cdf(count, mean):
    return sum(math.exp(k * math.log(mean) - mean - math.lgamma(k + 1)) for k in range(count + 1))


def poisson_mean(count, share):
    """The mean of which `count` or less are seen with this probability."""
    low, high = 1e-9, 10.0 + 3.0 * count
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if poisson_cdf(count, middle) > share else (low, middle)
    return low


def interval(count):
    return (poisson_mean(count - 1, 0.975) if count else 0.0), poisson_mean(count, 0.025)


def changes(arguments, recording, tolerance):
    """Seconds that were watched, and the changes seen in them [s]."""
    done = run(arguments.limber, "health", recording, "--json", "--false-alarms", arguments.rate, *tolerance)
    if not done.stdout:
        raise SystemExit(f"{recording}: {done.stderr.strip()}")
    health = json.loads(done.stdout)["health"]
    states = [*health["past"], health["present"]]
    return states[-1]["to_s"] - states[0]["from_s"], [state["from_s"] for state in states[1:]]


def watch(arguments, seed, names):
    """One recording: seconds that were watched, and the number of changes by tolerance."""
    text = (ROOT / f"scenarios/{arguments.scenario}.yaml").read_text()
    duration = next(line for line in text.splitlines() if line.startswith("duration:"))
    count, watched = {}, 0.0
    with tempfile.TemporaryDirectory() as folder:
        scenario, recording = pathlib.Path(folder) / "scenario.yaml", pathlib.Path(folder) / "recording"
        scenario.write_text(text.replace(duration, f"duration: {arguments.seconds:g}"))
        run(arguments.limber, "simulate", scenario, "--seed", seed, "--pixels", arguments.pixels, "--out", recording)
        for name in names:
            watched, seen = changes(arguments, recording, TOLERANCES[name])
            count[name] = len(seen)
            if arguments.details:
                print(json.dumps({"seed": seed, "tolerance": name, "seconds": watched, "changes_s": seen}), file=arguments.details,
                      flush=True)
    return watched, count


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=10.0)
    parser.add_argument("--rate", type=float, default=6.0, help="false alarms per hour that are asked for")
    parser.add_argument("--seed", type=int, default=1, help="of the first recording")
    parser.add_argument("--seconds", type=float, default=600.0, help="of a recording")
    parser.add_argument("--scenario", default="drone_none")
    parser.add_argument("--pixels", default="realistic", choices=["white", "realistic"])
    parser.add_argument("--tolerances", default="default,chance")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--details", type=argparse.FileType("w"), help="one JSON object a line: every recording")
    arguments = parser.parse_args()
    names = arguments.tolerances.split(",")
    count, seconds = dict.fromkeys(names, 0), 0.0
    try:
        for k in range(math.ceil(arguments.hours * 3600.0 / arguments.seconds)):
            watched, seen = watch(arguments, arguments.seed + k, names)
            seconds += watched
            for name in names:
                count[name] += seen[name]
    except KeyboardInterrupt:
        pass
    hours = seconds / 3600.0
    print("| scenario, pixels | tolerance | hours | asked per hour | changes | per hour (95 %) |")
    print("| --- " * 6 + "|")
    for name, seen in count.items():
        low, high = interval(seen)
        print(f"| {arguments.scenario}, {arguments.pixels} | {name} | {hours:.2f} | {arguments.rate:g} | {seen} | "
              f"{seen / hours:.2f} ({low / hours:.2f} to {high / hours:.2f}) |")


if __name__ == "__main__":
    main()
