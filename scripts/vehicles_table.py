#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Vehicles that drive, hover and sail: simulates their motion, runs it with default options, prints a table.

    scripts/vehicles_table.py build/release/limber --seeds 1 3 [--vehicles car_cruise,rover] [--inputs imu,vision,odometry]
                              [--rigs sound,constant,step] [--mount forward|side|back|down] [--imu good|poor]

The scenarios of this project fly splines and figures of eight. These begin at rest or at speed, drive straight on for a
minute, brake, nod, turn on the spot, hover or roll in waves: 60 s each, points ahead, realistic pixels, every tenth right
pixel missing. A seed draws bumps, points and noise.

Cells: SE(3) ATE [m] (ANEES) verdict, and the exit code if it is not 0.
"""
import argparse
import contextlib
import json
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from random_rigs_table import cell

STEP, LENGTH = 0.02, 62.0  # [s]
T = np.arange(0.0, LENGTH, STEP)

# Knots (time [s], value): speed [m/s] and yaw rate [rad/s]. Height of bumps [m] and their angle [rad].
WHEELED = {
    "car_rest": ([(0, 0), (4, 0), (9, 10), (20, 12), (24, 5), (29, 5), (35, 13), (45, 13), (50, 4), (56, 8), (62, 8)],
                 [(23.5, 0), (24.5, .35), (28.5, .35), (29.5, 0), (49, 0), (50, -.3), (54, -.3), (55, 0)], 0.01, 0.003),
    "car_cruise": ([(0, 14), (15, 14), (20, 8), (25, 8), (30, 15), (62, 15)],
                   [(19, 0), (20, .25), (25, .25), (26, 0), (40, 0), (41, .05), (50, .05), (51, -.05)], 0.01, 0.003),
    "highway": ([(0, 28)], [(20, 0), (25, .02), (40, -.02), (62, 0)], 0.005, 0.001),
    "robot": ([(0, 0), (3, 0), (3.6, .6), (9, .6), (9.6, 0), (14, 0), (14.6, .8), (24, .8), (24.6, 0), (30, 0), (30.6, .5),
               (44, .5), (44.6, 0), (50, 0), (50.5, .7)],
              [(10, 0), (10.3, .6), (13, .6), (13.3, 0), (18, 0), (18.3, .2), (22, .2), (22.3, 0), (26, 0), (26.3, -.8),
               (29, -.8), (29.3, 0), (34, 0), (35, .15), (42, .15), (43, 0)], 0.003, 0.003),
    "rover": ([(0, 0), (2, 0), (3, 1.5), (20, 2), (30, 1), (45, 2.5), (62, 2)],
              [(0, 0), (6, .3), (12, -.3), (20, .2), (30, -.4), (40, .3), (50, -.2), (62, .2)], 0.04, 0.03),
    "boat": ([(0, 2), (62, 3)], [(0, .02), (30, .08), (62, -.05)], 0.0, 0.003),
}
# Baseline [m], frames and samples [Hz], depths [m], image [px], focal length [px], points.
RIGS = {
    "car_rest": (.5, 10, 100, 3, 50, 1242, 375, 720, 1000), "car_cruise": (.35, 10, 100, 3, 50, 1242, 375, 720, 1700),
    "highway": (.5, 10, 200, 5, 70, 1242, 375, 720, 3000), "robot": (.075, 30, 200, .6, 8, 640, 480, 380, 500),
    "rover": (.25, 10, 100, 1, 20, 1024, 768, 600, 500), "boat": (.4, 15, 200, 4, 60, 1280, 720, 800, 500),
    "hover": (.11, 20, 200, 2, 20, 752, 480, 460, 150), "racer": (.1, 30, 400, 2, 20, 848, 480, 280, 350),
    "handheld": (.05, 30, 200, .5, 6, 848, 480, 430, 180),
}
BENT = {"sound": "", "constant": "decalibration: [{shape: constant, amplitude: [0.3, -0.5, 0.4, 4%, 0, 0]}]",
        "step": "decalibration: [{shape: steps, steps: [{at: 30, value: 1}], amplitude: [0.2, 0.3, -0.3, 0, 0, 0]}]"}
NOISE = {"good": "accel: 0.03, gyro: 0.1, accel_walk: 3e-3, gyro_walk: 2e-5",
         "poor": "accel: 0.2, gyro: 0.6, accel_walk: 1e-2, gyro_walk: 1e-4"}
BIASES = {"good": "bias_accel: 0.08, bias_gyro: 5e-3", "poor": "bias_accel: 0.3, bias_gyro: 2e-2"}
ODOMETRY = "odometry: {rate: 50, velocity: 0.05, angular_rate: 0.01}"
FORWARD = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], float)  # axes of a camera that looks along x of the body


def about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    out = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


MOUNTS = {"forward": FORWARD, "side": about(2, np.pi / 2) @ FORWARD, "back": about(2, np.pi) @ FORWARD,
          "down": about(1, np.radians(80)) @ FORWARD}


def smooth(x, seconds):
    n = int(seconds / STEP)
    kernel = np.hanning(n + 2)[1:-1]
    return np.convolve(np.pad(x, n, mode="edge"), kernel / kernel.sum(), "same")[n:-n]


def wander(rng, seconds, size):
    x = smooth(rng.standard_normal(len(T)), seconds)
    return size * x / x.std()


def turned(yaw, pitch, roll):
    return np.array([about(2, a) @ about(1, b) @ about(0, c) for a, b, c in zip(yaw, pitch, roll)])


def wheeled(name, rng):
    speed, rate, bump, angle = WHEELED[name]
    v, w = (smooth(np.interp(T, *zip(*knots)), 0.8) for knots in (speed, rate))
    yaw, moving = np.cumsum(w) * STEP, np.clip(np.abs(v) / 2, 0, 1)
    p = np.stack([np.cumsum(v * np.cos(yaw)) * STEP, np.cumsum(v * np.sin(yaw)) * STEP,
                  smooth(moving * wander(rng, 0.5, 1) * bump, 0.4)], 1)
    pitch = -0.01 * smooth(np.gradient(v, STEP), 0.4) + moving * wander(rng, 0.4, angle)
    roll = 0.01 * smooth(v * w, 0.4) + moving * wander(rng, 0.4, angle)
    if name == "boat":
        p[:, 2] += 0.3 * np.sin(2 * np.pi * T / 4) + 0.1 * np.sin(2 * np.pi * T / 2.3 + 1)
        pitch, roll = pitch + 0.05 * np.sin(2 * np.pi * T / 4 + 1), roll + 0.08 * np.sin(2 * np.pi * T / 3.3)
    return p, turned(yaw, pitch, roll)


def flown(p, yaw):
    """Thrust along z of the body."""
    a = np.gradient(np.gradient(p, STEP, axis=0), STEP, axis=0)
    z = a + [0, 0, 9.81]
    z /= np.linalg.norm(z, axis=1)[:, None]
    y = np.cross(z, np.stack([np.cos(yaw), np.sin(yaw), 0 * yaw], 1))
    y /= np.linalg.norm(y, axis=1)[:, None]
    return p, np.stack([np.cross(y, z), y, z], 2)


def trajectory(name, rng):
    """Positions and attitudes of the body: x forward, y left, z up."""
    if name in WHEELED:
        return wheeled(name, rng)
    if name == "hover":  # 15 s on the spot, then more, then far
        more = np.interp(T, [15, 20], [.1, 1])
        away = smooth(np.interp(T, [25, 35], [0, 1]), 2)
        p = np.stack([wander(rng, s, d) * more for s, d in ((3, .3), (3, .3), (4, .15))], 1)
        p += away[:, None] * np.stack([5 * np.sin(.3 * T), 3 * np.cos(.25 * T), 0 * T], 1)
        return flown(np.stack([smooth(x, 1) for x in p.T], 1), wander(rng, 10, .3))
    if name == "racer":
        phase = np.cumsum(smooth(np.interp(T, [3, 8], [0, 1]), 1.2)) * STEP * 2 * np.pi / 5 + rng.uniform(0, 6)
        p = np.stack([10 * np.sin(phase), 6 * np.sin(2 * phase), 1.5 * np.sin(3 * phase)], 1)
        v = np.gradient(p, STEP, axis=0)
        return flown(p, smooth(np.unwrap(np.arctan2(v[:, 1], v[:, 0] + 1e-3)), 0.6))
    p = np.stack([wander(rng, s, d) for s, d in ((2, .5), (2, .5), (1.5, .25))], 1)  # handheld
    return p, turned(wander(rng, 1.5, .7), wander(rng, 1.2, .35), wander(rng, 1.2, .3))


def quaternion(R):
    """x, y, z, w."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R.trace()]])
    return np.linalg.eigh(K)[1][:, -1]


def write(folder, name, seed, arguments, inputs, rig):
    p, R = trajectory(name, np.random.default_rng(seed))
    rows = [f"{100 + t:.3f} " + " ".join(f"{x:.9f}" for x in [*x, *quaternion(A)]) for t, x, A in zip(T, p, R)]
    (folder / "body.tum").write_text("\n".join(rows) + "\n")
    baseline, frames, samples, near, far, width, height, focal, points = RIGS[name]
    mount = ", ".join(f"{x:.9f}" for row, t in zip(MOUNTS[arguments.mount], (.3, .1, .1)) for x in [*row, t])
    camera = f"{{resolution: [{width}, {height}], intrinsics: [{focal}, {focal}, {width / 2}, {height / 2}]}}"
    imu = inputs == "imu"
    (folder / "scenario.yaml").write_text(f"""name: {name}
duration: 60
use_imu: {str(imu).lower()}
rates: {{stereo: {frames}{f", imu: {samples}" if imu else ""}}}
trajectory: {{kind: file, path: body.tum, start: 0.2, knot_spacing: 0.08}}
world: {{points: {points}, placement: in_view, min_distance: {near}, max_distance: {far}, max_range: {1.5 * far}}}
rig:
  theta: [0, 0.2, 0, {-baseline}, 0, 0]
  T_imu_cam0: [{mount}, 0, 0, 0, 1]
  cam0: {camera}
  cam1: {camera}
noise: {{pixel: 0.15, stated: false{", " + NOISE[arguments.imu] if imu else ""}}}
pixels: {{per_track: 0.25, correlated: 0.15, field: 0.1, mismatches: 0.02}}
{f"initial: {{{BIASES[arguments.imu]}}}" if imu else ""}
{ODOMETRY if inputs == "odometry" else ""}
dropout: {{right_detections: 0.1}}
{BENT[rig]}
""")


def run(arguments, name, inputs, rig, seed):
    cells = []
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        if arguments.keep:
            folder = arguments.keep / f"{name}_{inputs}_{rig}_{seed}"
            folder.mkdir(parents=True)
        write(folder, name, seed, arguments, inputs, rig)
        subprocess.run([arguments.limber, "simulate", folder / "scenario.yaml", "--seed", str(seed), "--out", folder / "log"],
                       check=True, capture_output=True)
        for method in arguments.methods:
            done = subprocess.run([arguments.limber, "run", folder / "log", "--method", method, "--out", folder / method],
                                  capture_output=True)
            file = folder / method / "summary.json"
            cells.append(cell(done.returncode, json.loads(file.read_text()) if file.exists() else None))
    return cells


def words(text):
    return text.split(",")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("limber", type=Path, help="the program")
    parser.add_argument("--seeds", type=int, nargs=2, default=[1, 1], metavar=("FIRST", "LAST"))
    parser.add_argument("--vehicles", type=words, default=list(RIGS))
    parser.add_argument("--inputs", type=words, default=["imu"])
    parser.add_argument("--rigs", type=words, default=["sound"])
    parser.add_argument("--methods", type=words, default=["ekf", "lcekf", "adaptive"])
    parser.add_argument("--mount", choices=MOUNTS, default="forward", help="where the cameras look")
    parser.add_argument("--imu", choices=NOISE, default="good")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=Path, help="folder for recordings and runs; must not have them yet")
    arguments = parser.parse_args()
    arguments.limber = arguments.limber.resolve()
    if arguments.keep:
        arguments.keep = arguments.keep.resolve()
    print("| vehicle | inputs | rig | seed |", " | ".join(f"`{m}`" for m in arguments.methods), "|")
    print("| --- |" + " --- |" * (3 + len(arguments.methods)))
    cases = [(name, inputs, rig, seed) for name in arguments.vehicles for inputs in arguments.inputs for rig in arguments.rigs
             for seed in range(arguments.seeds[0], arguments.seeds[1] + 1)]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for case, cells in zip(cases, pool.map(lambda case: run(arguments, *case), cases)):
            print("|", " | ".join(map(str, case)), "|", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
