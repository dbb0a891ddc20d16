#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Verdicts of limber health on rigs, lenses and motions that are drawn anew for each seed.

  scripts/rig_sweep_table.py [--runs N] [--seed N] [--limber PROGRAM] [--details FILE] [--full]

A seed draws a drone, a rover or a car, its baseline (0.06 to 1.2 m), focal length (250 to 900 px), image, lens, speed, rates,
sensors (IMU, odometry, both, neither), kind of pixels, and an axis with a shape over time. Each is judged sound, with twice
what is ok and twice what is wrong from the start, and with half of what is ok and twice what is wrong in its shape (`--full`:
half of what is ok and something far off from the start as well). Automatic start, default options.

`false`: sound or inside, and degraded or decalibrated. `missed`: twice what is ok or wrong, and ok (not of a pulse, which is
over). `named`: of those that are degraded or decalibrated. Covered are constant
errors and ramps, all axes, at the end of the present state. `said`: steps of twice what is wrong.
"""
import argparse
import collections
import json
import math
import pathlib
import random
import re
import tempfile

from verdict_table import AXES, ROOT, UNITS, VERDICTS, error_of, health, run

SHAPES = ["step", "ramp", "vibration", "pulse"]
LENSES = ["none", "none", "radial-tangential", "radial-tangential", "equidistant", "rational-polynomial", "omni"]


def waves(rng, t, amplitude, frequency):
    phases = [(g, rng.uniform(0, 6)) for g in (0.4, 1.0, 1.7)]
    return [sum(amplitude / 2 * math.sin(2 * math.pi * frequency * g * s + phase) for g, phase in phases) for s in t]


def turning(rng, n, dt, speed):
    """Rates of turn: straight ways and bends, smoothed over two seconds."""
    rates, k = [0.0] * n, 0
    while k < n:
        m = int(rng.uniform(2, 7) / dt)
        rate = rng.choice([0, 0, rng.uniform(-0.45, 0.45)]) * min(1, 8 / speed)
        rates[k:k + m] = [rate] * len(rates[k:k + m])
        k += m
    bell = [0.5 - 0.5 * math.cos(2 * math.pi * i / 40) for i in range(41)]
    total = sum(bell)
    return [sum(bell[j] / total * rates[k + j - 20] for j in range(41) if 0 <= k + j - 20 < n) for k in range(n)]


def write_ride(rng, duration, speed, file, bumpy):
    """A TUM file of a vehicle on wheels that pitches and rolls a little."""
    dt = 0.05
    t = [k * dt for k in range(int((duration + 4) / dt))]
    rates = turning(rng, len(t), dt, speed)
    period, phase = rng.uniform(12, 25), rng.uniform(0, 6)
    height = waves(rng, t, 0.02 * bumpy, 1.0)
    pitch = waves(rng, t, math.radians(0.5 * bumpy), 0.9)
    roll = waves(rng, t, math.radians(0.5 * bumpy), 0.8)
    x = y = yaw = 0.0
    with file.open("w") as out:
        for k, s in enumerate(t):
            yaw += rates[k] * dt
            v = speed * (1 + 0.25 * math.sin(2 * math.pi * s / period + phase))
            x, y = x + v * math.cos(yaw) * dt, y + v * math.sin(yaw) * dt
            (cy, sy), (cp, sp), (cr, sr) = [(math.cos(a / 2), math.sin(a / 2)) for a in (yaw, pitch[k], roll[k])]
            q = (sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy)
            print(f"{s:.3f} {x:.5f} {y:.5f} {height[k]:.5f} " + " ".join(f"{part:.8f}" for part in q), file=out)


def camera(rng, f, size, lens):
    fx = f * (1 + rng.gauss(0, 0.005))
    fy = fx * (1 + rng.gauss(0, 0.002))
    cx, cy = size[0] / 2 + rng.gauss(0, 8), size[1] / 2 + rng.gauss(0, 8)
    numbers = {"none": [], "radial-tangential": [-0.28 * rng.uniform(0.4, 1.0), 0.07 * rng.uniform(0.5, 1), rng.gauss(0, 3e-4), rng.gauss(0, 3e-4)],
               "equidistant": [rng.gauss(-0.01, 0.01), rng.gauss(0.005, 0.005), 0.0, 0.0],
               "rational-polynomial": [0.3, 0.05, 1e-4, -1e-4, 0.002, 0.6, 0.12, 0.01], "omni": [0.9, -0.1, 0.05, 1e-4, -2e-4]}[lens]
    coefficients = f", distortion_coefficients: [{', '.join(f'{v:.6g}' for v in numbers)}]" if numbers else ""
    return (f"{{resolution: [{size[0]}, {size[1]}], intrinsics: [{fx:.2f}, {fy:.2f}, {cx:.2f}, {cy:.2f}], "
            f"distortion_model: {lens}{coefficients}}}")


def draw(seed, folder):
    """Writes folder/scenario.yaml; says what else the sweep needs to know."""
    rng = random.Random(seed)
    kind = rng.choice(["drone8", "drone_spline", "rover", "car"])
    baseline = {"car": lambda: rng.uniform(0.25, 1.2), "rover": lambda: rng.uniform(0.1, 0.5)}.get(
        kind, lambda: math.exp(rng.uniform(math.log(0.06), math.log(0.4))))()
    size = rng.choice([(640, 480), (752, 480), (848, 480), (1280, 720), (1024, 768)])
    f = rng.uniform(max(250, 0.38 * size[0]), min(900, 0.95 * size[0]))
    duration, rate, imu_rate = rng.choice([20, 20, 30, 40]), rng.choice([10, 15, 20, 30]), rng.choice([100, 200, 400])
    sensor = rng.choice(["imu", "imu", "imu", "odometry", "vision", "imu+odometry"])
    if kind.startswith("drone"):
        sensor = rng.choice(["imu", "imu", "imu", "vision"])
    pixels, sigma = rng.choice(["white", "realistic", "realistic"]), rng.choice([0.2, 0.4, 0.8])
    speed = 0.0
    if kind == "drone8":
        speed = rng.uniform(1.2, 6)
        half = rng.uniform(3, 12) * max(1, speed / 4)
        path = (f"{{kind: figure_eight, half_length: {half:.2f}, height: {rng.uniform(0.3, 2):.2f}, min_speed: {0.6 * speed:.2f}, "
                f"max_speed: {speed:.2f}, tilt: {rng.uniform(2, 12):.1f}, rest: {rng.choice([0, 0, 3])}}}")
        near, far = rng.uniform(1.5, 4), rng.uniform(15, 45)
    elif kind == "drone_spline":
        speed = rng.uniform(1, 6)
        e = rng.uniform(8, 25)
        path = (f"{{kind: random_spline, half_extent: [{e:.1f}, {e:.1f}, {rng.uniform(2, 5):.1f}], max_speed: {speed:.2f}, "
                f"max_angular_rate: {rng.uniform(0.4, 1.0):.2f}, rest: {rng.choice([0, 0, 3])}}}")
        near, far = rng.uniform(1.5, 4), rng.uniform(20, 60)
    else:
        speed, bumps = (rng.uniform(0.5, 2.0), 3) if kind == "rover" else (rng.uniform(4, 15), 2)
        write_ride(rng, duration, speed, folder / "path.tum", rng.uniform(0.5, bumps))
        path = "{kind: file, path: path.tum, start: 0.5}"
        near, far = (rng.uniform(1.0, 3), rng.uniform(15, 40)) if kind == "rover" else (rng.uniform(4, 8), rng.uniform(50, 90))
    way = {"car": speed * duration / 100 * 0.6, "drone_spline": speed * duration / 90, "rover": speed * duration / 40}.get(kind, 0)
    points = int(rng.uniform(250, 450) * max(1, way))
    pitch = math.radians(rng.uniform(-8, 20))
    c, s = math.cos(pitch), math.sin(pitch)
    place = [rng.uniform(-0.2, 0.3), baseline / 2 * rng.choice([0, 1]), rng.uniform(-0.1, 0.2)]
    mount = [0, -s, c, place[0], -1, 0, 0, place[1], 0, -c, -s, place[2], 0, 0, 0, 1]
    theta = [rng.gauss(0, 0.3), rng.gauss(0, 0.5), rng.gauss(0, 0.3), -baseline, rng.gauss(0, 0.01) * baseline, rng.gauss(0, 0.01) * baseline]
    lens = rng.choice(LENSES)
    cameras = [camera(rng, f, size, lens) for _ in range(2)]
    noise = f"accel: {rng.choice([0.02, 0.05, 0.1])}, gyro: {rng.choice([0.05, 0.15, 0.3])}"
    odometry = (f"odometry: {{rate: 50, velocity: {rng.choice([0.03, 0.1])}, angular_rate: {rng.choice([0.005, 0.02])}}}\n"
                if "odometry" in sensor else "")
    (folder / "scenario.yaml").write_text(f"""duration: {duration}
rates: {{imu: {imu_rate}, stereo: {rate}}}
use_imu: {'true' if 'imu' in sensor else 'false'}
trajectory: {path}
world: {{points: {points}, placement: in_view, min_distance: {near:.1f}, max_distance: {far:.1f}, min_range: {0.6 * near:.1f}, max_range: {1.2 * far:.1f}}}
rig:
  theta: [{', '.join(f'{v:.6g}' for v in theta)}]
  T_imu_cam0: [{', '.join(f'{v:.9g}' for v in mount)}]
  cam0: {cameras[0]}
  cam1: {cameras[1]}
noise: {{{noise}, accel_walk: 1e-3, gyro_walk: 1e-5, pixel: {sigma}}}
{odometry}decalibration: []
""")
    axis, shape, sign = rng.choice(AXES), rng.choice(SHAPES), rng.choice([-1, 1])
    axis = "ty" if sensor == "vision" and axis == "tx" else axis  # nobody sees that length
    return {"seed": seed, "kind": kind, "sensor": sensor, "pixels": pixels, "lens": lens, "baseline": baseline, "focal": f, "size": size,
            "duration": duration, "rate": rate, "axis": axis, "shape": shape, "sign": sign}


def simulate(limber, drawn, folder):
    """With 25 to 65 points a frame, wherever the path leads."""
    target = random.Random(drawn["seed"] + 5).uniform(25, 65)
    scenario, recording = folder / "scenario.yaml", folder / "recording"
    for _ in range(4):
        done = run(limber, "simulate", scenario, "--seed", drawn["seed"], "--pixels", drawn["pixels"], "--out", recording, "--force")
        if done.returncode:
            raise SystemExit(f"seed {drawn['seed']}: {done.stderr.strip()}")
        with (recording / "mav0/tracks0/data.csv").open() as lines:
            seen = sum(1 for line in lines if not line.startswith("#")) / (drawn["duration"] * drawn["rate"])
        if 0.8 * target < seen < 1.25 * target:
            break
        text = scenario.read_text()
        now = int(re.search(r"points: (\d+)", text).group(1))
        scenario.write_text(text.replace(f"points: {now}", f"points: {max(40, int(now * target / max(seen, 0.5)))}"))
    return recording


def profile(shape, axis, size, unit, drawn):
    amplitude = ", ".join(f"{size * UNITS[unit]:.9g}" if name == axis else "0" for name in AXES)
    end, frequency = drawn["duration"], [2.1, 3.3, 5.7, 7.9][drawn["seed"] % 4]
    keys = {"step": f"shape: steps, steps: [{{at: {0.45 * end}, value: 1}}]", "ramp": f"shape: ramp, start: 0, end: {end}",
            "vibration": f"shape: vibration, frequency: {frequency}",
            "pulse": f"shape: steps, steps: [{{at: {0.3 * end}, value: 1}}, {{at: {0.6 * end}, value: 0}}]"}
    return f"decalibration:\n  - {{{keys[shape]}, amplitude: [{amplitude}]}}\n"


def errors(ok, wrong, unit, drawn, full):
    """(level, shape, size): what is done to the rig."""
    far = max(3.0 if unit == "deg" else 200 * drawn["baseline"], 2.5 * wrong)
    out = [("twice ok", "constant", 2 * ok), ("twice wrong", "constant", 2 * wrong), ("inside", drawn["shape"], 0.5 * ok),
           ("twice wrong", drawn["shape"], 2 * wrong)]
    return out + ([("inside", "constant", 0.5 * ok), ("far", "constant", far)] if full else [])


def judgements(limber, drawn, folder, full):
    """(level, shape, size [deg, mm], what limber health said)"""
    recording = simulate(limber, drawn, folder)
    sound = health(limber, recording, "")
    yield "sound", "constant", 0.0, sound
    if not sound["health"]:
        return
    band = sound["health"]["present"]["axes"][drawn["axis"]]
    if band["ok"] is None:  # nothing shows this axis
        return
    for level, shape, size in errors(band["ok"], band["wrong"], band["unit"], drawn, full):
        size *= drawn["sign"]
        if shape == "constant":
            yield level, shape, size, health(limber, recording, error_of(drawn["axis"], size, band["unit"]))
            continue
        (folder / "profile.yaml").write_text(profile(shape, drawn["axis"], size, band["unit"], drawn))
        run(limber, "decalibrate", recording, "--as", folder / "profile.yaml", "--out", folder / "bent", "--force")
        yield level, shape, size, health(limber, folder / "bent", "")


def size_at_end(shape, size, found):
    return size * {"constant": 1.0, "ramp": found["health"]["present"]["to_s"] / found["duration_s"]}[shape]


class Sweep:
    def __init__(self):
        self.verdicts = collections.defaultdict(collections.Counter)
        self.counts = collections.Counter()

    def count(self, what, yes):
        self.counts[what] += bool(yes)
        self.counts[f"all {what}"] += 1

    def add(self, drawn, level, shape, size, found):
        verdict, sound = found["verdict"], level in ("sound", "inside")
        self.verdicts[level, shape][verdict] += 1
        state = found["health"]["present"] if found["health"] else None
        self.count("mistakes", found["mistakes"])
        if sound:
            self.count("false", verdict in ("degraded", "decalibrated"))
        elif shape != "pulse":
            self.count("missed", verdict == "ok")
            if verdict in ("degraded", "decalibrated"):
                self.count("named", state["most_likely_axis"] == drawn["axis"])
        if state and shape in ("constant", "ramp"):
            truth = size_at_end(shape, size, found)
            for name, axis in state["axes"].items():
                if not (drawn["sensor"] == "vision" and name == "tx"):
                    self.count("covered", abs(axis["error"] - (truth if name == drawn["axis"] else 0.0)) <= 1.96 * axis["sigma"])
            if shape == "constant":
                self.count("changes of a constant rig", found["health"]["past"])
        if level == "twice wrong" and shape == "step":
            self.count("said", found["health"] and found["health"]["past"])

    def print(self):
        print("| rig | " + " | ".join(VERDICTS) + " |\n" + "| --- " * (len(VERDICTS) + 1) + "|")
        for (level, shape), counts in sorted(self.verdicts.items()):
            print(f"| {level}, {shape} | " + " | ".join(str(counts[v]) for v in VERDICTS) + " |")
        print("\n" + "; ".join(f"{what} {self.counts[what]} of {self.counts[f'all {what}']}"
                               for what in ("false", "missed", "named", "covered", "said", "changes of a constant rig", "mistakes")))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1, help="of the first run")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--details", type=argparse.FileType("w"), help="one JSON object a line: every judgement")
    parser.add_argument("--full", action="store_true")
    arguments = parser.parse_args()
    sweep = Sweep()
    for seed in range(arguments.seed, arguments.seed + arguments.runs):
        with tempfile.TemporaryDirectory() as folder:
            drawn = draw(seed, pathlib.Path(folder))
            for level, shape, size, found in judgements(arguments.limber, drawn, pathlib.Path(folder), arguments.full):
                sweep.add(drawn, level, shape, size, found)
                if arguments.details:
                    print(json.dumps({"drawn": drawn, "rig": level, "shape": shape, "size": size, "found": found}), file=arguments.details, flush=True)
    sweep.print()


if __name__ == "__main__":
    main()
