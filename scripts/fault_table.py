#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What limber makes of inputs that fail: corrupts a track log in stated ways, runs it, prints one table.

    scripts/fault_table.py build/release/limber scenarios/drone_none.yaml --seeds 1 2 3 --methods ekf,lcekf,adaptive

Every fault begins in the middle of the log (or at --at seconds), but for those of an IMU that errs all along. Figures are the
medians over the seeds of the SE(3) ATE [m] (with --init groundtruth position RMSE) and ANEES, and the verdicts; with --said
what the runs said of their inputs.
"""
import argparse
import json
import random
import re
import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

IMU = "mav0/imu0/data.csv"
TRACKS = "mav0/tracks0/data.csv"


def read(path):
    lines = path.read_text().splitlines()
    return lines[0], [line.split(",") for line in lines[1:]]


def write(path, head, rows):
    path.write_text("\n".join([head] + [",".join(row) for row in rows]) + "\n")


def imu_rows(edit):
    """A fault that maps the rows of the IMU: edit(rows as [t_ns, [6 numbers]], t0_ns, random) -> rows."""

    def apply(log, t0, rng):
        head, rows = read(log / IMU)
        numbers = [[int(r[0]), [float(x) for x in r[1:]]] for r in rows]
        write(log / IMU, head, [[str(t)] + [repr(x) for x in v] for t, v in edit(numbers, t0, rng)])

    return apply


def mixed(gyro, accel, askew=False):
    """All along: axes of either sensor longer or shorter by that share, or each mixed with the others by up to that."""

    def edit(rows, _, rng):
        def matrix(share):
            off = [[rng.uniform(-share, share) if askew else share * rng.choice([-1, 1]) * (i == j) for j in range(3)]
                   for i in range(3)]
            return [[off[i][j] + (i == j) for j in range(3)] for i in range(3)]

        of_gyro, of_accel = matrix(gyro), matrix(accel)
        times = lambda m, v: [sum(m[i][j] * v[j] for j in range(3)) for i in range(3)]
        return [[t, times(of_gyro, v[:3]) + times(of_accel, v[3:])] for t, v in rows]

    return imu_rows(edit)


def noisier(factor):
    """All along: white noise that many times as large as the recording states."""

    def apply(log, t0, rng):
        text = (log / IMU).with_name("sensor.yaml").read_text()
        gyro, accel = (float(re.search(rf"{name}_noise_density: *(\S+)", text)[1]) for name in ("gyroscope", "accelerometer"))

        def edit(rows, _, rng):
            rate = (len(rows) - 1) / (1e-9 * (rows[-1][0] - rows[0][0]))
            sigmas = [s * ((factor**2 - 1) * rate) ** 0.5 for s in [gyro] * 3 + [accel] * 3]
            return [[t, [x + rng.gauss(0.0, s) for x, s in zip(v, sigmas)]] for t, v in rows]

        imu_rows(edit)(log, t0, rng)

    return apply


def track_rows(edit):
    def apply(log, t0, rng):
        head, rows = read(log / TRACKS)
        write(log / TRACKS, head, edit(rows, t0, rng))

    return apply


def gap(seconds):
    return imu_rows(lambda rows, t0, _: [r for r in rows if not t0 < r[0] <= t0 + seconds * 1e9])


def stuck(seconds):
    def edit(rows, t0, _):
        held = None
        out = []
        for t, v in rows:
            if t0 < t <= t0 + seconds * 1e9:
                v = held
            else:
                held = v
            out.append([t, v])
        return out

    return imu_rows(edit)


def spike(size, seconds=0.0):
    def edit(rows, t0, _):
        out = []
        for t, v in rows:
            if t0 <= t <= t0 + seconds * 1e9:
                v = v[:3] + [v[3] + size, v[4], v[5]]
            out.append([t, v])
        return out

    return imu_rows(edit)


def gyro_step(size):
    return imu_rows(lambda rows, t0, _: [[t, [v[0] + size] + v[1:]] if t >= t0 else [t, v] for t, v in rows])


def accel_step(size):
    return imu_rows(
        lambda rows, t0, _: [[t, v[:3] + [v[3] + size] + v[4:]] if t >= t0 else [t, v] for t, v in rows]
    )


def clock(seconds):
    """The IMU's stamps jump: samples that would run backwards are lost."""

    def edit(rows, t0, _):
        out = []
        for t, v in rows:
            stamp = t + int(seconds * 1e9) if t >= t0 else t
            if not out or stamp > out[-1][0]:
                out.append([stamp, v])
        return out

    return imu_rows(edit)


def saturated(gyro, accel):
    clip = lambda x, limit: max(-limit, min(limit, x))
    return imu_rows(
        lambda rows, t0, _: [[t, [clip(x, gyro) for x in v[:3]] + [clip(x, accel) for x in v[3:]]] for t, v in rows]
    )


def late(seconds):
    """Each image arrives with the stamp of the next ones."""
    return imu_rows(lambda rows, t0, _: [[t + int(seconds * 1e9), v] for t, v in rows])


def outliers(share, which):
    """Gross mismatches, a fresh draw per point and frame: of the right pixel, or of both."""

    def edit(rows, t0, rng):
        out = []
        for r in rows:
            if r[1] and rng.random() < share:
                u, v = lambda: f"{rng.uniform(5, 747):.3f}", lambda: f"{rng.uniform(5, 475):.3f}"
                r = r[:2] + ([u(), v()] if which == "both" else r[2:4]) + ([u(), v()] if r[4] else r[4:])
            out.append(r)
        return out

    return track_rows(edit)


def moving_body(share):
    """From t0 on the points of one body (a share of all tracks) drift through both images, 40 px/s."""

    def edit(rows, t0, _):
        out = []
        for r in rows:
            t = int(r[0])
            if r[1] and t > t0 and int(r[1]) % 100 < 100 * share:
                d = 40e-9 * (t - t0)
                u = float(r[2]) + d
                r = r[:2] + [repr(u), r[3]] + ([repr(float(r[4]) + d), r[5]] if r[4] else r[4:])
                if u > 750:
                    continue
            out.append(r)
        return out

    return track_rows(edit)


def late_right(frames=1):
    """The right pixels are those of the frame before."""

    def edit(rows, t0, _):
        times = sorted({int(r[0]) for r in rows})
        before = {t: times[k - frames] if k >= frames else None for k, t in enumerate(times)}
        at = {(int(r[0]), r[1]): r for r in rows if r[1]}
        out = []
        for r in rows:
            old = at.get((before[int(r[0])], r[1])) if r[1] else None
            out.append(r[:4] + (old[4:] if old else ["", ""]))
        return out

    return track_rows(edit)


def no_points(seconds):
    return track_rows(lambda rows, t0, _: [r for r in rows if not t0 < int(r[0]) <= t0 + seconds * 1e9])


FAULTS = {
    "clean": lambda log, t0, rng: None,
    "IMU gap of 0.1 s": gap(0.1),
    "IMU gap of 1 s": gap(1.0),
    "IMU gap of 2 s": gap(2.0),
    "IMU gap of 5 s": gap(5.0),
    "IMU gap of 10 s": gap(10.0),
    "IMU stuck 1 s": stuck(1.0),
    "10 g in one sample": spike(98.1),
    "100 g in one sample": spike(981.0),
    "3 g for 50 ms": spike(29.4, 0.05),
    "gyroscope saturated at 0.7 of its peak": None,
    "gyro bias step 0.05 rad/s": gyro_step(0.05),
    "accelerometer bias step 0.5 m/s^2": accel_step(0.5),
    "IMU clock +0.1 s": clock(0.1),
    "IMU clock -0.1 s": clock(-0.1),
    "IMU all along: gyroscope's axes off by 0.5 %": mixed(0.005, 0.0),
    "IMU all along: gyroscope's axes off by 1 %": mixed(0.01, 0.0),
    "IMU all along: accelerometer's axes off by 1 %": mixed(0.0, 0.01),
    "IMU all along: all axes askew by up to 1 %": mixed(0.01, 0.01, askew=True),
    "IMU all along: noise 3 times as stated": noisier(3.0),
    "IMU all along: noise 10 times as stated": noisier(10.0),
    "2 % right pixels wrong": outliers(0.02, "right"),
    "10 % right pixels wrong": outliers(0.1, "right"),
    "30 % right pixels wrong": outliers(0.3, "right"),
    "2 % of both pixels wrong": outliers(0.02, "both"),
    "10 % of both pixels wrong": outliers(0.1, "both"),
    "30 % of both pixels wrong": outliers(0.3, "both"),
    "40 % on one moving body": moving_body(0.4),
    "right images one frame late": late_right(),
    "no points for 1 s": no_points(1.0),
    "no points for 10 s": no_points(10.0),
}


def saturate_at_peak(log, t0, rng):
    _, rows = read(log / IMU)
    peak = max(abs(float(x)) for r in rows for x in r[1:4])
    saturated(0.7 * peak, 1e9)(log, t0, rng)


FAULTS["gyroscope saturated at 0.7 of its peak"] = saturate_at_peak


def figures(program, log, method, init, out, more):
    run = subprocess.run(
        [program, "run", log, "--method", method, "--init", init, "--out", out, *more],
        capture_output=True,
        text=True,
    )
    summary = Path(out) / "summary.json"
    if not summary.exists():
        return float("inf"), float("inf"), run.returncode, run.stderr.strip().splitlines()[-1:], None
    s = json.loads(summary.read_text())
    verdict = s["health"]["verdict"] if s["health"] else "-"
    said = [n for n in s["notes"] if any(w in n for w in ("gap", "no sample", "IMU", "lost", "input", "stuck"))]
    shutil.rmtree(out)
    rmse = s["ate_m"]["se3"] if init == "auto" else s["position_rmse_m"]
    return rmse, s["anees"], run.returncode, said, verdict


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenario")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--methods", default="ekf,lcekf,adaptive")
    parser.add_argument("--init", choices=["auto", "groundtruth"], default="auto")
    parser.add_argument("--pixels", choices=["white", "realistic"], default="realistic")
    parser.add_argument("--at", type=float, default=12.0, help="when the fault begins [s]")
    parser.add_argument("--only", default="", help="faults whose name contains this")
    parser.add_argument("--run-options", default="", help="of limber run, such as '--imu-noise stated'")
    parser.add_argument("--said", action="store_true", help="print what the runs said, too")
    a = parser.parse_args()
    methods = a.methods.split(",")
    with tempfile.TemporaryDirectory() as folder:
        clean = {}
        for seed in a.seeds:
            clean[seed] = Path(folder) / f"seed{seed}"
            subprocess.run(
                [a.program, "simulate", a.scenario, "--pixels", a.pixels, "--seed", str(seed), "--out", clean[seed]],
                check=True,
                capture_output=True,
            )
        print("| fault | " + " | ".join(methods) + " |")
        print("| --- |" + " --- |" * len(methods))
        for name, fault in FAULTS.items():
            if not any(word in name for word in a.only.split(",")):
                continue
            row, words = [], []
            for method in methods:
                results = []
                for seed in a.seeds:
                    log = Path(folder) / "log"
                    shutil.rmtree(log, ignore_errors=True)
                    shutil.copytree(clean[seed], log)
                    fault(log, int(a.at * 1e9), random.Random(seed))
                    results.append(figures(a.program, log, method, a.init, f"{folder}/out", a.run_options.split()))
                rmse = statistics.median(r[0] for r in results)
                anees = statistics.median(r[1] if r[1] is not None else float("inf") for r in results)
                codes = sorted({r[2] for r in results if r[2]})
                verdicts = sorted({str(r[4]) for r in results})
                row.append(
                    f"{rmse:.3g} ({anees:.3g}) {'/'.join(verdicts)}" + (f" exit {codes[0]}" if codes else "")
                )
                words += [w for r in results for w in r[3]]
            print(f"| {name} | " + " | ".join(row) + " |", flush=True)
            if a.said:
                for word in sorted(set(words))[:4]:
                    print(f"    {word}")


if __name__ == "__main__":
    main()
