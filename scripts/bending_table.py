#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How flat the methods are on rendered recordings of a rig that bends: a table of docs/evidence/benchmarks.md.

  scripts/bending_table.py [--vehicles drone,rover] [--scene room|hall|street] [--duration S] [--seed N] [--degrees D]
                           [--percent P] [--methods NAME,...] [--out DIR]

Pictures are drawn by `limber simulate --images`, and run with default options, from the sensors alone. A cell: SE(3) ATE [m],
ANEES, and what it is times that of the sound rig.
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
BASES = {"drone": "drone_none", "rover": "rover_ramp"}


def shapes(degrees, percent, duration):
    amplitude = f"[{0.4 * degrees}, {degrees}, {0.4 * degrees}, {percent}%, {0.1 * percent}%, {0.1 * percent}%]"
    return {
        "sound": "[]",
        "constant": f"[{{shape: constant, amplitude: {amplitude}}}]",
        "step": f"[{{shape: steps, steps: [{{at: {0.5 * duration}, value: 1}}], amplitude: {amplitude}}}]",
        "square wave 1 Hz": f"[{{shape: square_wave, period: 1, amplitude: {amplitude}}}]",
        "ramp": f"[{{shape: ramp, start: {0.1 * duration}, end: {0.9 * duration}, amplitude: {amplitude}}}]",
    }


def scenario(vehicle, shape, duration):
    text = (ROOT / f"scenarios/{BASES[vehicle]}.yaml").read_text()
    text = re.sub(r"(?m)^duration:.*\n", "", text.partition("decalibration:")[0])
    return f"duration: {duration}\n{text}decalibration: {shape}\n"


def run(arguments, vehicle, name, shape):
    folder = arguments.out / f"{vehicle} {name}".replace(" ", "_")
    if not (folder / "done").exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "scenario.yaml").write_text(scenario(vehicle, shape, arguments.duration))
        pictures = folder / "pictures"
        subprocess.run([arguments.limber, "simulate", folder / "scenario.yaml", "--images", "--image-noise", "2", "--scene",
                        arguments.scene, "--seed", str(arguments.seed), "--out", pictures], check=True, capture_output=True)
        done = subprocess.run([arguments.limber, "run", pictures, "--methods", arguments.methods, "--out", folder / "runs"],
                              capture_output=True, text=True)
        (folder / "log").write_text(done.stdout + done.stderr)
        shutil.rmtree(pictures)
        (folder / "done").write_text(f"{done.returncode}\n")
    return {method: json.loads((folder / f"runs/{method}/summary.json").read_text())
            for method in arguments.methods.split(",")}


def cell(summary, sound):
    ate, flat = summary["ate_m"]["se3"], sound["ate_m"]["se3"]
    verdict = summary["health"]["verdict"]
    return f"{ate:.3f} ({summary['anees']:.2f}), {ate / flat:.2f} ×, {verdict}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vehicles", default="drone,rover")
    parser.add_argument("--scene", default="hall")
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--degrees", type=float, default=3.0)
    parser.add_argument("--percent", type=float, default=20.0)
    parser.add_argument("--methods", default="ekf,lcekf,adaptive")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results/bending")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    arguments = parser.parse_args()
    methods = arguments.methods.split(",")
    print("| recording | " + " | ".join(methods) + " |\n" + "| --- " * (len(methods) + 1) + "|", flush=True)
    for vehicle in arguments.vehicles.split(","):
        sound = None
        for name, shape in shapes(arguments.degrees, arguments.percent, arguments.duration).items():
            runs = run(arguments, vehicle, name, shape)
            sound = sound or runs
            print(f"| {vehicle}, {name} | " + " | ".join(cell(runs[m], sound[m]) for m in methods) + " |", flush=True)


if __name__ == "__main__":
    main()
