#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How good the start from the sensors is beside the truth's: the table of docs/evidence/start.md.

  scripts/start_table.py [--runs N] [--seed N] [--pixels white|realistic] [--scenarios NAME,...] [--methods NAME,...]
                         [--out DIR]

Two studies, which go on where they were stopped. A cell: medians over the runs of the position RMSE, aligned by SE(3), from
the sensors and from the truth, their ratio; in brackets ANEES of the pose, ANEES of the scale and the worst run over the
median, from the sensors and then from the truth.
"""
import argparse
import pathlib
import sqlite3
import statistics
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
METHODS = "ekf,lcekf,adaptive,ekf-full"
SCENARIOS = ("paper_i,paper_ii,paper_iii,paper_iv,paper_v_strong,drone_moving,drone_none,drone_constant,drone_square,"
             "drone_step,drone_none_vision")


def study(arguments, start):
    database = arguments.out / f"{arguments.pixels}_{start}.sqlite"
    files = [ROOT / f"scenarios/{name}.yaml" for name in arguments.scenarios.split(",")]
    subprocess.run([arguments.limber, "study", *files, "--methods", arguments.methods, "--runs", str(arguments.runs),
                    "--seed", str(arguments.seed), "--init", start, "--pixels", arguments.pixels, "--brief", "--out",
                    database], check=True, stdout=subprocess.DEVNULL)
    rows = sqlite3.connect(f"file:{database}?mode=ro", uri=True).execute(
        "SELECT c.name, method, run, ate_se3_m, anees, anees_scale, start_s FROM runs JOIN cases c ON c.id = case_id")
    return {tuple(row[:3]): row[3:] for row in rows}


def median(values):
    values = [value for value in values if value is not None]
    return statistics.median(values) if values else float("nan")


def quality(rows):
    """ANEES of the pose and of the scale, medians, and the worst run over the median."""
    worst = max(row[0] for row in rows) / median(row[0] for row in rows)
    return f"({median(row[1] for row in rows):.2f}, {median(row[2] for row in rows):.2f}, {worst:.1f})"


def cell(sensors, truth, case, method):
    runs = [key for key in sensors if key[:2] == (case, method) and key in truth and sensors[key][0] and truth[key][0]]
    if not runs:
        return "–"
    ours, theirs = [sensors[k] for k in runs], [truth[k] for k in runs]
    auto, known = median(row[0] for row in ours), median(row[0] for row in theirs)
    return f"{auto:.3f} / {known:.3f} = {auto / known:.2f} {quality(ours)} {quality(theirs)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--pixels", choices=["white", "realistic"], default="white")
    parser.add_argument("--scenarios", default=SCENARIOS)
    parser.add_argument("--methods", default=METHODS)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results/start")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    sensors, truth = study(arguments, "auto"), study(arguments, "groundtruth")
    methods = arguments.methods.split(",")
    print("| scenario | " + " | ".join(methods) + " | started after [s] (worst) |")
    print("| --- " * (len(methods) + 2) + "|")
    for case in dict.fromkeys(key[0] for key in sensors):
        started = [row[3] for key, row in sensors.items() if key[0] == case and methods[key[1]] != "ekf"]
        cells = [cell(sensors, truth, case, method) for method in range(len(methods))]
        print(f"| {case} | " + " | ".join(cells) + f" | {median(started):.1f} ({max(started):.1f}) |")


if __name__ == "__main__":
    main()
