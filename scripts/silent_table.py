#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Which runs are wrong by more than their sigmas say, and whether they say so: a table of docs/evidence/faults.md.

    scripts/silent_table.py build/release/limber --seed 1101 [--methods ekf,lcekf,ekf-full] [--only NAME] [--all]

Short recordings with faults of odd sizes and times, each with a seed of its own, run with default options. A row is a run
with ten frames or more whose position or attitude is off by more than five sigmas (root of NEES per degree of freedom),
with --all any run. It is SILENT if it ended with exit code 0, the verdict ok, and no remark that anything is wrong.
"""
import argparse
import csv
import json
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

SCENARIOS = Path(__file__).resolve().parent.parent / "scenarios"
WORDS = ("contradict", "the run is lost", "its sigma", "px of pixel noise", "broken down", "take the rig for exact")
LASTING = "per_track: 0.3, correlated: 0.15, field: 0.2"


def rig(shape, degrees, percent):
    sizes = [0.4 * degrees, degrees, 0.4 * degrees] + [f"{s * percent}%" for s in (1, 0.1, 0.1)]
    return f"decalibration: [{{{shape}, amplitude: [{', '.join(str(s) for s in sizes)}]}}]"


def drone_cases():
    for size, pixels in ((0.1, "realistic"), (0.15, "white"), (0.3, "realistic")):
        yield "drone_none", pixels, f"accel-bias-step={11}:{size}"
    for size, pixels in ((0.004, "realistic"), (0.02, "white")):
        yield "drone_none", pixels, f"gyro-bias-step=10:{size}"
    for size, pixels in ((0.02, "realistic"), (-0.04, "white")):
        yield "drone_none", pixels, f"clock-step=12:{size}"
    for fault in ("imu-stuck=9:0.4", "imu-gap=9:3", "imu-spike=9:2", "imu-saturation=16:35", "right-late=8:6:0.05",
                  "frames-repeated=11:0.5", "frame-gap=10:3"):
        yield "drone_none", "realistic", fault


def other_cases():
    for fault in ("accel-bias-step=7:0.3", "gyro-bias-step=6:0.01", "clock-step=8:0.06", "imu-stuck=7:1.5", "imu-gap=6:4",
                  "right-late=4:20:0.1", "frames-repeated=7:1"):
        yield "drone_moving", "realistic", fault
    for fault in ("accel-bias-step=7:0.25", "gyro-bias-step=6:0.01", "clock-step=14:0.05", "imu-spike=9:5", "imu-gap=15:7",
                  "imu-saturation=1.02:20", "right-late=9:30:0.1", "frame-gap=11:6"):
        yield "paper_iv", "realistic", fault
    for fault in ("accel-bias-step=13:0.2", "clock-step=9:0.1", "imu-gap=9:4"):
        yield "rover_ramp", "realistic", fault
    yield "rover_shock", "white", "gyro-bias-step=16:0.02"


def cases():
    """(scenario, pixels, fault of simulate, line of the scenario file or nothing)"""
    for name in ("drone_none", "drone_moving", "paper_i", "rover_ramp"):
        for pixels in ("white", "realistic"):
            yield name, pixels, "", ""
    for name, pixels, fault in (*drone_cases(), *other_cases()):
        yield name, pixels, fault, ""
    yield "drone_none", "", "", f"pixels: {{mismatches: 0.05, {LASTING}}}"
    for name, body in (("drone_none", "{share: 0.3, speed: 1.5, radius: 3, start: 8}"),
                       ("rover_ramp", "{share: 0.5, speed: 1, radius: 2, start: 6}")):
        yield name, "realistic", "", f"moving_body: {body}"
    ramp = "shape: ramp, start: 3, end: 22"
    yield "drone_none", "realistic", "", rig(ramp, 3, 20)
    yield "drone_none", "realistic", "", rig(ramp, 6, 30)
    yield "drone_none", "white", "", rig("shape: steps, steps: [{at: 12, value: 1}]", 2, 10)
    yield "drone_none", "realistic", "", rig("shape: square_wave, period: 1", 3, 20)
    yield "drone_moving", "realistic", "", rig("shape: constant", 1, 5)


def scenario(name, line):
    text = (SCENARIOS / f"{name}.yaml").read_text()
    if line.startswith("decalibration"):
        text = text.partition("decalibration:")[0]
    if line.startswith("moving_body"):
        text, n = re.subn(r"(?m)^world: \{", f"world: {{{line}, ", text)
        line = "" if n else f"world: {{{line}}}"
    text = re.sub(r"(?m)^duration:.*\n", "", text)
    return f"duration: {15 if name == 'drone_moving' else 25}\n{text}{line}\n"


def columns(path, *prefixes):
    """Those whose name begins so, a column each."""
    with open(path) as file:
        names = file.readline().lstrip("#").strip().split(",")
        rows = np.array([[float(x or "nan") for x in row] for row in csv.reader(file)])
    return rows[:, [k for k, name in enumerate(names) if name.startswith(prefixes)]]


def rotations(q):
    w, x, y, z = q.T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return np.array(rows).transpose(2, 0, 1)


def turns(R):
    """Rotation vectors, of less than half a turn."""
    angle = np.arccos(np.clip((np.trace(R, axis1=1, axis2=2) - 1) / 2, -1, 1))
    axis = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1)
    return axis * np.where(angle < 1e-6, 0.5, angle / (2 * np.sin(np.maximum(angle, 1e-9))))[:, None]


def sigmas(error, P):
    return np.sqrt(np.einsum("ni,nij,nj->n", error, np.linalg.pinv(P), error) / error.shape[1])


def sigmas_off(folder):
    """Of each frame after the first second, the larger of position and attitude; the truth is aligned already."""
    t = columns(folder / "trajectory.csv", "t_ns")[:, 0]
    p, q = columns(folder / "trajectory.csv", "px", "py", "pz"), columns(folder / "trajectory.csv", "q")
    upper = columns(folder / "trajectory.csv", "P_")
    true_p, true_q = columns(folder / "truth.csv", "p_RS"), columns(folder / "truth.csv", "q_RS")
    P = np.zeros((len(t), 6, 6))
    P[:, *np.triu_indices(6)] = upper
    P += np.triu(P, 1).transpose(0, 2, 1)
    turn = turns(rotations(q).transpose(0, 2, 1) @ rotations(true_q))
    off = np.maximum(sigmas(true_p - p, P[:, :3, :3]), sigmas(turn, P[:, 3:, 3:]))
    return off[t > t[0] + 1e9]


def judge(folder):
    summary = json.loads((folder / "summary.json").read_text())
    off = sigmas_off(folder)
    verdict = summary["health"]["verdict"] if summary["health"] else "-"
    lost = summary["lost_since_s"]
    said = any(word in note for note in summary["notes"] for word in WORDS)
    beyond = int((off > 5).sum())
    silent = beyond >= 10 and lost is None and not said and verdict == "ok"
    what = f"lost since {lost:.1f} s" if lost is not None else "SILENT" if silent else "said" if said else "-"
    events = ", ".join(sorted({event["what"] for event in summary["events"]}))
    return beyond, f"{summary['ate_m']['se3']:.3g} | {off.max():.1f} | {beyond} | {verdict} | {what} | {events}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seed", type=int, default=1, help="of the first recording; each has the next one")
    parser.add_argument("--methods", default="ekf,lcekf,ekf-full")
    parser.add_argument("--only", default="", help="recordings whose name contains this")
    parser.add_argument("--all", action="store_true", help="runs within their sigmas, too")
    a = parser.parse_args()
    print("| recording | method | ATE [m] | largest error [σ] | frames beyond 5 σ | verdict | said | events |")
    print("| --- " * 8 + "|", flush=True)
    for k, (name, pixels, fault, line) in enumerate(cases()):
        title = " ".join(filter(None, (name, pixels, fault, line.replace("decalibration: ", "rig "))))
        if a.only not in title:
            continue
        with tempfile.TemporaryDirectory() as folder:
            base = Path(folder)
            (base / "s.yaml").write_text(scenario(name, line))
            options = [*(["--pixels", pixels] if pixels else []), *(["--fault", fault] if fault else [])]
            subprocess.run([a.program, "simulate", base / "s.yaml", "--seed", str(a.seed + k), *options, "--out",
                            base / "log"], check=True, capture_output=True)
            subprocess.run([a.program, "run", base / "log", "--methods", a.methods, "--out", base / "runs"],
                           capture_output=True)
            for method in a.methods.split(","):
                if not (base / "runs" / method / "summary.json").exists():
                    print(f"| {title} | {method} | diverged, exit 1 | | | | | |", flush=True)
                    continue
                beyond, row = judge(base / "runs" / method)
                if a.all or beyond >= 10:
                    print(f"| {title} | {method} | {row} |", flush=True)


if __name__ == "__main__":
    main()
