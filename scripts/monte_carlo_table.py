#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Monte Carlo over the shipped scenarios with `limber simulate` and `limber run`; prints the table of docs/results.md.

  scripts/monte_carlo_table.py [--runs 20] [--seed 1] [--jobs 2] [--scenarios paper_i,...] [--methods ekf,...]

Starts are drawn (--init groundtruth), the gate is off (matching is perfect), the map holds up to 400 landmarks.
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENARIOS = ["paper_i", "paper_ii", "paper_iii", "paper_iv", "paper_v", "paper_v_strong",
             "drone_none", "drone_constant", "drone_step", "drone_square"]
METHODS = ["ekf", "ekf-full", "lcekf", "mono-left"]


def one_run(limber, scenario, methods, seed, run):
    """summary.json of each method on one simulated recording; None where it diverged."""
    with tempfile.TemporaryDirectory() as folder:
        log = pathlib.Path(folder) / "log"
        subprocess.run([limber, "simulate", ROOT / f"scenarios/{scenario}.yaml", "--seed", str(seed), "--run", str(run),
                        "--out", log], check=True, capture_output=True)
        out = {}
        for method in methods:
            name, _, landmarks = method.partition(":")
            result = pathlib.Path(folder) / "run"
            done = subprocess.run([limber, "run", log, "--method", name, "--out", result, "--init", "groundtruth",
                                   "--gate", "off", "--max-landmarks", "400", "--seed", str(seed), "--run", str(run),
                                   "--landmarks", landmarks or "inverse-depth"], capture_output=True, check=False)
            out[method] = json.loads((result / "summary.json").read_text()) if done.returncode == 0 else None
        return out


def row(scenario, method, summaries):
    good = [s for s in summaries if s is not None]
    diverged = len(summaries) - len(good)
    note = f", {diverged} diverged" if diverged else ""
    if not good:
        return f"| {scenario} | {method} | all {diverged} diverged | | | |"
    rmse = [s["position_rmse_m"] for s in good]
    total = math.sqrt(sum(r * r for r in rmse) / len(rmse))
    anees = sum(s["anees"] for s in good) / len(good)
    attitude = math.sqrt(sum(s["attitude_rmse_deg"] ** 2 for s in good) / len(good))
    return f"| {scenario} | {method} | {total:.4f}{note} | {max(rmse):.3f} | {attitude:.4f} | {anees:.2f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--scenarios", default=",".join(SCENARIOS))
    parser.add_argument("--methods", default=",".join(METHODS), help="METHOD or METHOD:cartesian, comma-separated")
    arguments = parser.parse_args()
    methods = arguments.methods.split(",")
    print("| scenario | method | position RMSE [m] | worst run [m] | attitude RMSE [deg] | ANEES |")
    print("| --- | --- | --- | --- | --- | --- |")
    for scenario in arguments.scenarios.split(","):
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            runs = list(pool.map(lambda r: one_run(arguments.limber, scenario, methods, arguments.seed, r),  # noqa: B023
                                 range(arguments.runs)))
        for method in methods:
            print(row(scenario, method, [r[method] for r in runs]), flush=True)


if __name__ == "__main__":
    main()
