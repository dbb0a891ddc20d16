#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs limber on every real recording, sound and decalibrated, and prints the table of docs/evidence/real-data.md.

  scripts/real_data_table.py [--data DIR] [--limber PROGRAM] [--out DIR] [--sigma-px S] [--jobs N] [--only WORDS]

The decalibration is the paper's delta: rotation as printed, translation in the same proportion to the baseline. A run that says
of itself that it is lost, which ends with exit code 1, is shown with its figures and with the time since when.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DELTA = "0.01,-0.05,0.1,5%,-0.5%,0.25%"
RECORDINGS = {  # path: (scale is fixed by an IMU or odometry, further decalibrations)
    "track_logs/euroc_imu_april": (True, ["0,2,0,20%,0,0"]),
    "track_logs/kitti_09_26_drive_0001": (True, []),
    "track_logs/kitti_09_26_drive_0005": (True, []),
    "track_logs/kitti_09_26_drive_0036": (True, []),
    "track_logs/kitti_09_26_drive_0095": (True, []),
    "track_logs/kitti_09_30_drive_0020": (True, []),
    "track_logs/kitti_09_30_drive_0027": (True, []),
    "track_logs/starry_night": (True, []),
    "euroc_mh01_a": (True, []),
    "kitti_06_first51": (False, []),
}


def variants(fixed_scale):
    yield "ekf", []
    yield "ekf-full", []
    yield "lcekf", ["--constraints", "full"]
    if not fixed_scale:
        yield "lcekf", ["--constraints", "rotation+direction"]
        yield "lcekf", ["--constraints", "rotation"]
    yield "adaptive", []
    yield "mono-left", []


def without_points(recording, folder):
    """A copy of a track log in which each frame has one point, seen once by the left camera, which says nothing: what the
    odometry alone is worth."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(recording, folder)
    tracks = folder / "mav0/tracks0/data.csv"
    header, *rows = tracks.read_text().splitlines()
    stamps = dict.fromkeys(row.split(",", 1)[0] for row in rows)
    lone = [f"{stamp},{10**6 + n},100,100,," for n, stamp in enumerate(stamps)]
    tracks.write_text("\n".join([header, *lone]) + "\n")
    return folder


def jobs(data, out):
    for name, (fixed_scale, more) in RECORDINGS.items():
        if not (data / name).exists():
            print(f"real_data_table: {data / name} is not there: left out", file=sys.stderr)
            continue
        if (data / name / "mav0/odometry0").exists():
            blind = without_points(data / name, out / f"{pathlib.Path(name).name}-no-points")
            folder = out / f"{pathlib.Path(name).name}-odometry"
            yield pathlib.Path(name).name, "–", "odometry alone", folder, [blind, "--out", folder, "--force"]
        for error in ["", DELTA, *more]:
            for method, options in variants(fixed_scale):
                label = method + (f" ({options[1]})" if options else "")
                folder = out / f"{name.replace('/', '_')}-{label.replace(' ', '')}-{error.replace('%', 'p') or 'given'}"
                command = [data / name, "--method", method, "--out", folder, "--force", *options]
                if error:
                    command += ["--assume-error", error]
                yield pathlib.Path(name).name, error or "given", label, folder, command


def run(limber, folder, command):
    shutil.rmtree(folder, ignore_errors=True)
    done = subprocess.run([limber, "run", *command], capture_output=True, text=True, check=False)
    summary = folder / "summary.json"
    if not summary.exists():  # else exit code 1 says what the summary says: lost since when, or never corrected
        return done.stderr.strip().splitlines()[-1]
    return json.loads(summary.read_text())


def lost(summary):
    """ ", lost since 12.3 s" of the run; not where no frame corrected the state by intent: odometry alone."""
    no_update = summary["frames_by_status"]["updated"] == 0
    return "" if summary["lost_since_s"] is None or no_update else ", " + summary["answer"]["headline"].split(",")[0]


def cell(value, digits):
    return "–" if value is None else f"{value:.{digits}f}" if abs(value) < 1e4 else f"{value:.1e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("LIMBER_DATA", ROOT / "../shared/data"))
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results/real_data")
    parser.add_argument("--sigma-px", help="pixel noise for all; default: what limber run chooses")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", help="rows whose recording and method contain all of these words")
    arguments = parser.parse_args()
    if not arguments.limber.exists():
        sys.exit(f"{arguments.limber} is not there: build it with scripts/demo.sh, or name it with --limber")
    arguments.out.mkdir(parents=True, exist_ok=True)
    work = list(jobs(pathlib.Path(arguments.data), arguments.out))
    if arguments.only:
        work = [job for job in work if all(word in f"{job[0]} {job[2]}" for word in arguments.only.split())]
    if arguments.sigma_px:
        work = [(*job[:4], [*job[4], "--sigma-px", arguments.sigma_px]) for job in work]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(lambda job: run(arguments.limber, job[3], job[4]), work))
    print("| recording | calibration | method | SE(3) ATE [m] | Sim(3) ATE [m] | scale | of path | NIS/dof | refused | x real time |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for (name, error, label, _, _), s in zip(work, results):
        if isinstance(s, str):
            print(f"| {name} | {error} | {label} | failed: {s} | | | | | | |")
            continue
        ate = s["ate_m"]
        share = None if ate["se3"] is None or not s["path_length_m"] else 100 * ate["se3"] / s["path_length_m"]
        print(f"| {name} | {error} | {label}{lost(s)} | {cell(ate['se3'], 4)} | {cell(ate['sim3'], 4)} | {cell(ate['scale'], 4)} "
              f"| {cell(share, 2)} % | {cell(s['nis_per_dof'], 2)} | {s['points_refused']} | {cell(s['realtime_factor'], 1)} |")


if __name__ == "__main__":
    main()
