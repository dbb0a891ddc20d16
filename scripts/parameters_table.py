#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a wrong focal length, principal point, time offset or mount does to each way of treating it.

    scripts/parameters_table.py --limber build/release/limber --runs 20 --out parameters.sqlite

Runs a study (or goes on with it) over the drone and the paper's rover, both with a sound rig, and prints a Markdown
table: position RMSE in metres (root of the mean square over runs) and ANEES of the pose.
"""
import argparse
import math
import sqlite3
import subprocess

SCENARIOS = ["scenarios/drone_none.yaml", "scenarios/paper_i.yaml"]
# What is assumed wrong, and how it is named where it is treated.
ERRORS = [
    ("dt1=0.005", "dt1"),
    ("dt0=0.005,dt1=0.005", "dt0,dt1"),
    ("fu1=1%", "fu1"),
    ("cu1=3,radial1=0.02", "cu1,radial1"),
    ("fu0=1%,fv0=1%,fu1=1%,fv1=1%", "fu0,fv0,fu1,fv1"),
    ("imu-ax=0.5,imu-ay=-0.3,imu-tx=0.02,imu-tz=-0.02", "imu"),
]
TREATMENTS = [
    ("`ekf`", "ekf"),
    ("`lcekf`", "lcekf:full"),
    ("`ekf`, estimated", "ekf:estimate={names}"),
    ("`lcekf`, estimated", "lcekf:full:estimate={names}"),
    ("`ekf`, softened", "ekf:soften={names}"),
    ("constrained alone", "lcekf:{names}"),
    ("constrained with θ", "lcekf:full,{names}"),
]


def variants():
    for error, names in ERRORS:
        for _, treatment in TREATMENTS:
            yield f"{treatment.format(names=names)}:assume={error}"


def read(path):
    """{case: {assumed error: [(rmse, anees) by treatment, in the order of the study]}}"""
    query = """select c.name, m.label, m.method, r.position_rmse_m, r.anees from runs r join cases c on c.id = r.case_id
               join methods m on m.case_id = r.case_id and m.method = r.method order by c.name, m.method"""
    cells = {}
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as database:
        for case, label, method, rmse, anees in database.execute(query):
            _, assumed, error = label.partition(":assume=")
            if assumed:
                cells.setdefault(case, {}).setdefault(error, {}).setdefault(method, []).append((rmse, anees))
    return {case: {error: list(by.values()) for error, by in errors.items()} for case, errors in cells.items()}


def text(runs):
    """RMSE (ANEES) over the runs that did not diverge, and how many did."""
    kept = [(rmse, anees) for rmse, anees in runs if rmse is not None]
    if not kept:
        return f"{len(runs)} diverged"
    rmse = math.sqrt(sum(r * r for r, _ in kept) / len(kept))
    anees = sum(a for _, a in kept) / len(kept)
    lost = f", {len(runs) - len(kept)} diverged" if len(kept) < len(runs) else ""
    return f"{rmse:.4f} ({anees:.2g}{lost})" if anees < 10 else f"{rmse:.3f} ({anees:.0f}{lost})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limber", default="build/release/limber")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--out", required=True, help="the study's database; made, or gone on with")
    arguments = parser.parse_args()
    methods = ",".join(["ekf", "lcekf", *variants()])
    subprocess.run([arguments.limber, "study", *SCENARIOS, "--methods", methods, "--init", "groundtruth", "--runs", str(arguments.runs),
                    "--out", arguments.out], check=True, stdout=subprocess.DEVNULL)
    for case, errors in read(arguments.out).items():
        print(f"\n{case}:\n")
        print("| assumed wrong | " + " | ".join(name for name, _ in TREATMENTS) + " |")
        print("| --- " * (len(TREATMENTS) + 1) + "|")
        for error, cells in errors.items():
            print(f"| {error} | " + " | ".join(text(runs) for runs in cells) + " |")


if __name__ == "__main__":
    main()
