#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs limber health on real recordings, as given and decalibrated, and prints the table of docs/evidence/health.md.

  scripts/health_table.py [--data DIR] [--limber PROGRAM] [--only NAME]...

The column 'found' is of the axis that was changed, else of the one furthest from zero in sigmas.
"""
import argparse
import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
AXES = ["ax", "ay", "az", "tx", "ty", "tz"]
ERRORS = ["", "0.3,0,0,0,0,0", "0,0.3,0,0,0,0", "0,0,0.3,0,0,0", "0,0,0,3%,0,0"]
RECORDINGS = ["track_logs/euroc_imu_april", "euroc_mh01_a", "euroc_mh01_d", "euroc_v101_imu_gt", "kitti_06_first51",
              "track_logs/starry_night",
              *(f"track_logs/kitti_{k}" for k in ("09_26_drive_0001", "09_26_drive_0005", "09_26_drive_0036",
                                                  "09_26_drive_0095", "09_30_drive_0020", "09_30_drive_0027"))]


def health(limber, recording, error):
    command = [limber, "health", recording, "--json"] + (["--assume-error", error] if error else [])
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.stdout else done.stderr.strip().splitlines()[-1]


def found(state, error):
    changed = [AXES[k] for k, value in enumerate(error.split(",")) if value not in ("", "0")]
    axes = state["axes"]
    name = changed[0] if changed else max(AXES, key=lambda a: abs(axes[a]["error"]) / axes[a]["sigma"])
    axis = axes[name]
    return f"{name} {axis['error']:+.3f} ± {axis['sigma']:.3f} {axis['unit']}"


def interval(effect):
    return f"{effect['size']:.2f} ({effect['low']:.2f} to {effect['high']:.2f})"


def row(name, error, d):
    if isinstance(d, str):
        return f"| {name} | {error or 'given'} | failed: {d} | | | | | |"
    h = d["health"]
    if h is None:
        return f"| {name} | {error or 'given'} | {d['verdict']} | | | {'; '.join(d['mistakes'])} | | |"
    state = h["present"]
    return (f"| {name} | {error or 'given'} | {d['verdict']} | {interval(state['epipolar_px'])} | "
            f"{interval(state['depth_percent'])} | {found(state, error)} | {state['most_likely_axis'] or '–'} | "
            f"{len(h['past'])} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("LIMBER_DATA", ROOT / "../shared/data"))
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--only", action="append", help="names of recordings; default: all")
    arguments = parser.parse_args()
    print("| recording | added to the calibration | verdict | off the line [px] | depth [%] | found (true - assumed) | "
          "explains it best | changes |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for recording in RECORDINGS:
        name = pathlib.Path(recording).name
        if arguments.only and name not in arguments.only:
            continue
        for error in ERRORS:
            result = health(arguments.limber, pathlib.Path(arguments.data) / recording, error)
            print(row(name, error, result), flush=True)


if __name__ == "__main__":
    main()
