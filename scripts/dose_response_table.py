#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How the error of a run grows with the error of its calibration: multiples of the paper's delta, per recording and method.

  scripts/dose_response_table.py [--limber PROGRAM] [--methods ekf,lcekf,mono-left] RECORDING...

Prints SE(3) ATE in metres, in brackets the Sim(3) scale. Delta: rotation as printed, translation in the same proportion to
the baseline.
"""
import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
DELTA = [(0.01, ""), (-0.05, ""), (0.1, ""), (5, "%"), (-0.5, "%"), (0.25, "%")]
DOSES = [-4, -2, -1, 0, 1, 2, 4]


def cell(limber, recording, method, dose):
    error = ",".join(f"{dose * value:g}{unit}" for value, unit in DELTA)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([limber, "run", recording, "--method", method, f"--assume-error={error}", "--out",
                               pathlib.Path(folder) / "run"], capture_output=True, text=True, check=False)
        summary = pathlib.Path(folder) / "run/summary.json"
        if not summary.exists():
            return "failed: " + done.stderr.strip().splitlines()[-1]
        ate = json.loads(summary.read_text())["ate_m"]
        return f"{ate['se3']:.3g} ({ate['scale']:.3f})" + (", lost" if done.returncode else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+", type=pathlib.Path)
    parser.add_argument("--methods", default="ekf,lcekf,mono-left")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    rows = [(recording, method) for recording in arguments.recordings for method in arguments.methods.split(",")]
    work = [(arguments.limber, *row, dose) for row in rows for dose in DOSES]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        cells = list(pool.map(lambda job: cell(*job), work))
    print("| recording | method | " + " | ".join(f"{dose:+d} delta" if dose else "given" for dose in DOSES) + " |")
    print("| --- " * (2 + len(DOSES)) + "|")
    for k, (recording, method) in enumerate(rows):
        print(f"| {recording.name} | {method} | " + " | ".join(cells[k * len(DOSES):(k + 1) * len(DOSES)]) + " |")


if __name__ == "__main__":
    main()
