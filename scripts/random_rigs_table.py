#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Rigs, scenes and flights that nobody chose: draws scenarios at random, runs them with default options, prints a table.

    scripts/random_rigs_table.py build/release/limber --seeds 1 40 --methods ekf,lcekf,adaptive [--faults] [--images] [--motion vision]

A seed draws baseline, lenses, rates, mount, IMU, flight, points and, of nearly half of the rigs, how they bend. --faults adds
mismatches, missing pixels, frames and samples, and to half of the recordings a fault of the IMU or of the images; --motion
leaves the IMU out; --images renders them.

Cells: SE(3) ATE [m] (ANEES) verdict, and the exit code if it is not 0. The last lines count.
"""
import argparse
import collections
import contextlib
import json
import math
import random
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

OF_IMAGES = ["right_late", "frame_gap", "frames_repeated"]
AXES = [0, 0, 1, -1, 0, 0, 0, -1, 0]  # of a camera that looks along x of the body, row by row


def between(rng, low, high):
    """As likely in each octave."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def multiply(a, b):
    return [sum(a[3 * i + k] * b[3 * k + j] for k in range(3)) for i in range(3) for j in range(3)]


def turn(rng, degrees):
    out = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    for i, j in ((1, 2), (2, 0), (0, 1)):
        angle = math.radians(rng.uniform(-degrees, degrees))
        about = [float(r == c) for r in range(3) for c in range(3)]
        about[4 * i] = about[4 * j] = math.cos(angle)
        about[3 * i + j], about[3 * j + i] = -math.sin(angle), math.sin(angle)
        out = multiply(about, out)
    return out


def camera(rng, images):
    width, height = rng.choice([(640, 480), (752, 480), (848, 480)] + ([(424, 240)] if images else [(1280, 720)]))
    focal = width / 2 / math.tan(math.radians(rng.uniform(60, 105)) / 2)
    out = {"resolution": [width, height],
           "intrinsics": [focal, focal * rng.uniform(0.995, 1.005), width / 2 + rng.gauss(0, 8), height / 2 + rng.gauss(0, 8)]}
    lens = rng.choice([None, ("radial-tangential", [-0.15, 0.03, 2e-4, -1e-4]), ("equidistant", [-0.01, 0.01, -5e-3, 1e-3])])
    if lens:
        out["distortion_model"], out["distortion_coefficients"] = lens
    return out


def flight(rng, images):
    if rng.random() < 1 / 3:
        slowest = rng.uniform(0.5, 2)
        out = {"kind": "figure_eight", "half_length": 4 if images else rng.uniform(3, 15), "min_speed": slowest,
               "max_speed": 1.6 * slowest, "tilt": rng.uniform(2, 12), "height": rng.uniform(0.2, 1.5)}
    else:
        size = 5 if images else rng.uniform(3, 30)
        out = {"kind": "random_spline", "half_extent": [size, size, 0.2 * size],
               "max_speed": between(rng, 0.5, 2.5 if images else 8), "max_angular_rate": rng.uniform(0.2, 1.5),
               "knot_spacing": rng.uniform(2, 5), "max_angles": [rng.uniform(3, 25)] * 2 + [180]}
    if rng.random() < 0.3:
        out["rest"] = rng.uniform(1, 4)
    return out


def bend(rng):
    """@return what it is called, and the signals"""
    kind, size = rng.choices([("sound", 0), ("constant", 1), ("steps", 0.5), ("square_wave", 0.3), ("ramp", 0.7),
                              ("vibration", 0.1)], [55, 12, 10, 8, 8, 7])[0]
    keys = {"steps": {"steps": [{"at": 10, "value": 1}]}, "square_wave": {"period": 1}, "ramp": {"start": 5, "end": 20},
            "vibration": {"frequency": 12}}.get(kind, {})
    amplitude = [rng.gauss(0, size) for _ in range(3)] + [f"{rng.gauss(0, 6 * size):.4f}%" for _ in range(3)]
    return kind, [] if kind == "sound" else [{"shape": kind, **keys, "amplitude": amplitude}]


def fault(rng, frame_s):
    at = rng.uniform(1, 20)
    kind, keys = rng.choice([
        ("gyro_bias_step", {"size": rng.choice([0.005, 0.02, 0.05])}), ("accel_bias_step", {"size": rng.choice([0.1, 0.3])}),
        ("imu_spike", {"size": rng.choice([3, 10, 100])}), ("imu_stuck", {"duration": rng.uniform(0.1, 1)}),
        ("imu_gap", {"duration": rng.uniform(0.1, 3)}), ("clock_step", {"size": rng.choice([0.02, 0.1, -0.05])}),
        ("right_late", {"duration": 3, "delay": frame_s}), ("frame_gap", {"duration": rng.uniform(0.2, 2)}),
        ("frames_repeated", {"duration": rng.uniform(0.2, 1.5)})])
    return {"kind": kind, "at": at, **keys}


def scenario(rng, images, faults):
    """@return the scenario, and what is to be known of it"""
    baseline = between(rng, 0.06, 0.6)
    stereo_hz, imu_hz = rng.choice([10, 15, 20, 30]), rng.choice([100, 200, 400])
    near = max(8 * baseline, 0.6)
    far = near * rng.uniform(8, 25)
    R, t = multiply(turn(rng, 20), AXES), [rng.uniform(-0.2, 0.2) for _ in range(3)]
    mount = [x for i in range(3) for x in R[3 * i:3 * i + 3] + [t[i]]] + [0, 0, 0, 1]
    kind, signals = bend(rng)
    trajectory = flight(rng, images)
    out = {
        "duration": 14 if images else 25,
        "rates": {"imu": imu_hz, "stereo": stereo_hz},
        "trajectory": trajectory,
        "world": {"points": rng.randint(150, 450), "placement": "in_view", "min_distance": near, "max_distance": far,
                  "min_range": 0.7 * near, "max_range": 1.2 * far},
        "rig": {"theta": [rng.gauss(0, 1) for _ in range(3)] + [-baseline] + [rng.gauss(0, 0.02 * baseline) for _ in range(2)],
                "T_imu_cam0": mount, "cam0": camera(rng, images)},
        "noise": {"accel": between(rng, 1e-3, 2e-2) * imu_hz**0.5, "gyro": math.degrees(between(rng, 6e-5, 1.6e-3)) * imu_hz**0.5,
                  "accel_walk": between(rng, 1e-4, 2e-3), "gyro_walk": between(rng, 5e-6, 1e-4)},
        "initial": {"bias_accel": rng.uniform(0.01, 0.15), "bias_gyro": between(rng, 1e-3, 2e-2)},
        "decalibration": signals,
    }
    if not images:
        out["pixels"] = "realistic"
    name = f"{kind}, b {baseline:.2f} m, {stereo_hz}/{imu_hz} Hz, {trajectory['max_speed']:.1f} m/s, points {near:.1f}–{far:.0f} m"
    if faults:
        out["noise"].update(pixel=rng.uniform(0.05, 0.3), stated=False)
        out["pixels"] = {"per_track": rng.uniform(0.1, 0.4), "correlated": rng.uniform(0.05, 0.25), "field": rng.uniform(0, 0.2),
                         "mismatches": rng.choice([0, 0.01, 0.03, 0.1])}
        out["dropout"] = {"right_detections": rng.choice([0, 0.05, 0.2, 0.4]), "frames": rng.choice([0, 0.02]),
                          "imu_samples": rng.choice([0, 0.01])}
        if rng.random() < 0.5:
            out["faults"] = [fault(rng, 1 / stereo_hz)]
    return out, kind, name


def without_imu(out, motion, rng):
    """The same with odometry, or with nothing but points."""
    out["use_imu"] = False
    out["rates"].pop("imu")
    flown = out["trajectory"]
    flown["max_speed"] = min(flown["max_speed"], 3)
    if "min_speed" in flown:
        flown["min_speed"] = min(flown["min_speed"], flown["max_speed"] / 1.5)
    if motion == "odometry":
        out["odometry"] = {"rate": rng.choice([20, 50]), "velocity": between(rng, 0.01, 0.1),
                           "angular_rate": between(rng, 0.005, 0.05)}
    out.get("dropout", {}).pop("imu_samples", None)
    out["faults"] = [f for f in out.get("faults", []) if f["kind"] in OF_IMAGES]


def switches(rng):
    """Of pictures."""
    out = ["--images", "--scene", rng.choice(["room", "hall", "street"]), "--image-noise", f"{rng.uniform(0, 4):.1f}",
           "--gain-difference", rng.choice(["0", "0.1", "0.3"]), "--vignetting", rng.choice(["0", "0.3"]),
           "--exposure", rng.choice(["0", "0.005", "0.01"]), "--low-texture", rng.choice(["0", "0.3"])]
    out += ["--moving-objects", "3"] if rng.random() < 0.3 else []
    return out + (["--dropped", "0.03"] if rng.random() < 0.3 else [])


def run_seed(arguments, seed):
    rng = random.Random(seed)
    drawn, kind, name = scenario(rng, arguments.images, arguments.faults)
    if arguments.motion != "imu":
        without_imu(drawn, arguments.motion, rng)
    name += "".join(f", {fault['kind']}" for fault in drawn.get("faults", []))
    cells = {}
    with contextlib.ExitStack() as stack:
        if arguments.keep:
            folder = arguments.keep / str(seed)
            folder.mkdir(parents=True)
        else:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / f"seed_{seed}.yaml").write_text(json.dumps(drawn))
        of_images = switches(rng) if arguments.images else []
        made = subprocess.run([arguments.limber, "simulate", folder / f"seed_{seed}.yaml", "--seed", str(seed), "--out",
                               folder / "log", *of_images], capture_output=True, text=True)
        if made.returncode:  # no room for moving objects, say
            return seed, kind, made.stderr.strip(), cells
        for method in arguments.methods:
            done = subprocess.run([arguments.limber, "run", folder / "log", "--method", method, "--out", folder / method],
                                  capture_output=True)
            file = folder / method / "summary.json"
            cells[method] = (done.returncode, json.loads(file.read_text()) if file.exists() else None)
    return seed, kind, name + (f", {of_images[2]}" if of_images else ""), cells


def cell(code, summary):
    if summary is None:
        return f"no result, exit {code}"
    text = f"{summary['ate_m']['se3']:.3f} ({summary['anees']:.1f}) {summary['health']['verdict']}"
    return text + (f", exit {code}" if code else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("limber", type=Path)
    parser.add_argument("--seeds", type=int, nargs=2, default=[1, 20], metavar=("FIRST", "LAST"))
    parser.add_argument("--methods", type=lambda text: text.split(","), default=["ekf", "lcekf", "adaptive"])
    parser.add_argument("--faults", action="store_true")
    parser.add_argument("--motion", choices=["imu", "odometry", "vision"], default="imu", help="what drives the prediction")
    parser.add_argument("--images", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="leave scenarios, recordings and results there, by seed")
    arguments = parser.parse_args()
    print("| seed | rig | " + " | ".join(f"`{method}`" for method in arguments.methods) + " |")
    print("| --- | --- |" + " --- |" * len(arguments.methods))
    verdicts, wrong, nees = collections.Counter(), collections.Counter(), collections.defaultdict(list)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for seed, kind, name, cells in pool.map(lambda s: run_seed(arguments, s),
                                                range(arguments.seeds[0], arguments.seeds[1] + 1)):
            row = (cell(*cells[method]) if method in cells else "" for method in arguments.methods)
            print(f"| {seed} | {name} | " + " | ".join(row) + " |", flush=True)
            for method, (_, summary) in cells.items():
                verdicts[method, kind, summary and summary["health"]["verdict"]] += 1
                if summary and (kind == "sound" or method != "ekf"):  # ekf is not made for rigs that bend
                    nees[method].append(summary["anees"])
                    wrong[method] += summary["anees"] > 3
    print()
    for method in arguments.methods:
        values = sorted(nees[method])
        if values:
            print(f"{method}: ANEES median {values[len(values) // 2]:.2f}, worst {values[-1]:.1f}, above 3 in {wrong[method]} of "
                  f"{len(values)} runs" + (" of sound rigs" if method == "ekf" else ""))
    for (method, kind, verdict), count in sorted(verdicts.items(), key=str):
        print(f"{method}: {kind} rigs, {verdict}: {count}")


if __name__ == "__main__":
    main()
