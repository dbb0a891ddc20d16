#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs limber health on real recordings, as given and decalibrated, and prints the table of docs/health.md.

  scripts/health_table.py [--data DIR] [--limber PROGRAM] [--only NAME]...

The column 'found' is delta_mean: of the axis that was changed, else of the one furthest from zero in sigmas.
"""
import argparse
import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
AXES = ["ax", "ay", "az", "tx", "ty", "tz"]
ERRORS = ["", "0.1,0,0,0,0,0", "0,0.1,0,0,0,0", "0,0,0.1,0,0,0", "0,0,0,1%,0,0"]
RECORDINGS = ["track_logs/euroc_imu_april", "euroc_mh01_a", "track_logs/starry_night",
              *(f"track_logs/kitti_09_26_drive_{k}" for k in ("0001", "0005", "0036", "0095"))]


def health(limber, recording, error):
    command = [limber, "health", recording, "--json"] + (["--assume-error", error] if error else [])
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.stdout else done.stderr.strip().splitlines()[-1]


def found(h, error):
    mean, sigma = h["delta_mean"], h["delta_sigma"]
    changed = [k for k, value in enumerate(error.split(",")) if value not in ("", "0")]
    k = changed[0] if changed else max(range(6), key=lambda i: abs(mean[i]) / sigma[i])
    return f"{AXES[k]} {mean[k]:+.4f} ± {sigma[k]:.4f} {'deg' if k < 3 else 'mm'}"


def row(name, error, d):
    if isinstance(d, str):
        return f"| {name} | {error or 'given'} | failed: {d} | | | |"
    h = d["health"]
    if h is None:
        return f"| {name} | {error or 'given'} | {d['verdict']} | | | {'; '.join(d['mistakes'])} |"
    named = ", ".join(a for a in AXES if h["axes"][a] == "decalibrated") or "–"
    alarm = "–" if h["first_alarm_s"] is None else f"{h['first_alarm_s']:.2f}"
    return (f"| {name} | {error or 'given'} | {d['verdict']} | {alarm} | {named} | {found(h, error)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("LIMBER_DATA", ROOT / "../shared/data"))
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--only", action="append", help="names of recordings; default: all")
    arguments = parser.parse_args()
    print("| recording | added to the calibration | verdict | first alarm [s] | axes that moved | found (true - assumed) |")
    print("| --- | --- | --- | --- | --- | --- |")
    for recording in RECORDINGS:
        name = pathlib.Path(recording).name
        if arguments.only and name not in arguments.only:
            continue
        for error in ERRORS:
            result = health(arguments.limber, pathlib.Path(arguments.data) / recording, error)
            print(row(name, error, result), flush=True)


if __name__ == "__main__":
    main()
