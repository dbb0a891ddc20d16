#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Monte Carlo over the shipped scenarios with `limber simulate` and `limber run`; prints the tables of docs/results.md.

  scripts/monte_carlo_table.py [--runs 20] [--seed 1] [--jobs 2] [--scenarios paper_i,...] [--methods ekf,...]

Starts are drawn (--init groundtruth), the gate is off (matching is perfect), the map holds up to 400 landmarks.
First one row per scenario and method as they are done, then all methods side by side: position RMSE [m] (ANEES).
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENARIOS = {
    "paper_i": "(i) none",
    "paper_ii": "(ii) constant",
    "paper_iii": "(iii) sinus",
    "paper_iv": "(iv) steps",
    "paper_v": "(v) square wave",
    "paper_v_strong": "(v-strong), 0.5 m",
    "drone_none": "drone, none",
    "drone_constant": "drone, constant",
    "drone_step": "drone, step at 5 s",
    "drone_square": "drone, square wave",
}
METHODS = ["ekf", "ekf-full", "lcekf", "mono-left"]
DRONE_METHODS = [*METHODS, "lcekf:cartesian"]  # the paper's landmarks, which such a rig is too small for


def one_run(limber, scenario, methods, seed, run):
    """summary.json of each method on one simulated recording; None where it diverged."""
    with tempfile.TemporaryDirectory() as folder:
        log = pathlib.Path(folder) / "log"
        done = subprocess.run([limber, "simulate", ROOT / f"scenarios/{scenario}.yaml", "--seed", str(seed),
                               "--run", str(run), "--out", log], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(done.stderr)
        out = {}
        for method in methods:
            name, _, landmarks = method.partition(":")
            result = pathlib.Path(folder) / "run"
            done = subprocess.run([limber, "run", log, "--method", name, "--out", result, "--init", "groundtruth",
                                   "--gate", "off", "--max-landmarks", "400", "--seed", str(seed), "--run", str(run),
                                   "--landmarks", landmarks or "inverse-depth"],
                                  capture_output=True, text=True, check=False)
            if done.returncode != 0 and " diverged: " not in done.stderr:
                sys.exit(done.stderr)
            out[method] = json.loads((result / "summary.json").read_text()) if done.returncode == 0 else None
        return out


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def figures(summaries):
    """Over the runs that did not diverge: position RMSE, worst run, attitude RMSE, ANEES; and how many diverged."""
    good = [s for s in summaries if s is not None]
    if not good:
        return None, len(summaries)
    position = [s["position_rmse_m"] for s in good]
    return (rms(position), max(position), rms([s["attitude_rmse_deg"] for s in good]),
            sum(s["anees"] for s in good) / len(good)), len(summaries) - len(good)


def diverged_note(diverged):
    return f", {diverged} diverged" if diverged else ""


def row(scenario, method, summaries):
    known, diverged = figures(summaries)
    if known is None:
        return f"| {scenario} | {method} | all {diverged} diverged | | | |"
    position, worst, attitude, anees = known
    return (f"| {scenario} | {method} | {position:.4f}{diverged_note(diverged)} | {worst:.3f} | {attitude:.4f} "
            f"| {anees:.2f} |")


def cell(summaries):
    if summaries is None:
        return "–"
    known, diverged = figures(summaries)
    if known is None:
        return "all diverged"
    position, _, _, anees = known
    return f"{position:.4f} ({anees:.{2 if anees < 10 else 0}f}){diverged_note(diverged)}"


def side_by_side(results, runs):
    methods = list(dict.fromkeys(method for of_scenario in results.values() for method in of_scenario))
    yield f"| case, {runs} runs | " + " | ".join(m.replace(":cartesian", ", Cartesian") for m in methods) + " |"
    yield "| --- " * (len(methods) + 1) + "|"
    for scenario, of_scenario in results.items():
        cells = [cell(of_scenario.get(method)) for method in methods]
        yield f"| {SCENARIOS.get(scenario, scenario)} | " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scenarios", default=",".join(SCENARIOS))
    parser.add_argument("--methods", help="METHOD or METHOD:cartesian, comma-separated; default: "
                        + ",".join(METHODS) + ", and lcekf:cartesian for the drone")
    arguments = parser.parse_args()
    if not arguments.limber.exists():
        sys.exit(f"{arguments.limber} is not there: build it with scripts/demo.sh, or name it with --limber")
    print("| scenario | method | position RMSE [m] | worst run [m] | attitude RMSE [deg] | ANEES |")
    print("| --- | --- | --- | --- | --- | --- |")
    results = {}
    for scenario in arguments.scenarios.split(","):
        methods = (arguments.methods.split(",") if arguments.methods
                   else DRONE_METHODS if scenario.startswith("drone") else METHODS)
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            runs = list(pool.map(lambda r: one_run(arguments.limber, scenario, methods, arguments.seed, r),  # noqa: B023
                                 range(arguments.runs)))
        results[scenario] = {method: [r[method] for r in runs] for method in methods}
        for method in methods:
            print(row(scenario, method, results[scenario][method]), flush=True)
    print()
    print("\n".join(side_by_side(results, arguments.runs)))


if __name__ == "__main__":
    main()
