#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes each common mistake in a copy of a recording, and asks `limber health` what is wrong.

  scripts/mistake_table.py RECORDING... [--only TEXT,...] [--run METHOD] [--limber FILE]

RECORDING: a folder in EuRoC's layout, with images or a track log, or a KITTI odometry sequence, calibrated right. A row: the
mistake, the verdict, what was named. Of a mistake that a recording cannot have (of an IMU that it does not hold) the row says so.
--run asks `limber run` instead: exit code, verdict, ATE and ANEES, what was named.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def columns(file, change):
    """Changes the numbers of each line of a CSV file."""
    lines = file.read_text().splitlines()
    file.write_text("\n".join(x if x.startswith("#") or not x.strip() else ",".join(change(x.split(","))) for x in lines) + "\n")


def scaled(row, first, last, factor):
    return row[:first] + [repr(float(x) * factor) for x in row[first:last]] + row[last:]


def matrix(sensor):
    text = re.search(r"(?s)T_BS:.*?data:\s*\[(.*?)\]", sensor.read_text()).group(1)
    x = [float(v) for v in text.split(",")]
    return [x[4 * i:4 * i + 4] for i in range(4)]


def set_matrix(sensor, m):
    flat = ", ".join(repr(v) for row in m for v in row)
    sensor.write_text(re.sub(r"(?s)(T_BS:.*?data:\s*\[).*?\]", lambda found: found.group(1) + flat + "]", sensor.read_text()))


def inverse(m):
    rotation = [[m[j][i] for j in range(3)] for i in range(3)]
    shift = [-sum(rotation[i][k] * m[k][3] for k in range(3)) for i in range(3)]
    return [[*rotation[i], shift[i]] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def sensors(mav0):
    return [mav0 / f"cam{k}/sensor.yaml" for k in (0, 1)]


def imu(first, last, factor):
    return lambda mav0: columns(mav0 / "imu0/data.csv", lambda row: scaled(row, first, last, factor))


def imu_late(seconds):
    return lambda mav0: columns(mav0 / "imu0/data.csv", lambda row: [str(int(row[0]) + round(1e9 * seconds)), *row[1:]])


def imu_in_seconds(mav0):
    columns(mav0 / "imu0/data.csv", lambda row: [f"{1e-9 * int(row[0]):.6f}", *row[1:]])


def swapped(mav0):
    """Pictures (or pixels) of the one under the name of the other, calibrations stay."""
    tracks = mav0 / "tracks0/data.csv"
    if tracks.exists():
        columns(tracks, lambda row: [*row[:2], *row[4:6], *row[2:4]] if "" not in row[2:6] else row)
        return
    for name in ("data", "data.csv"):
        one, other, aside = mav0 / "cam0" / name, mav0 / "cam1" / name, mav0 / "aside"
        one.rename(aside), other.rename(one), aside.rename(other)


def inverted(which):
    def change(mav0):
        for k in which:
            set_matrix(sensors(mav0)[k], inverse(matrix(sensors(mav0)[k])))
    return change


def shifted_cameras(*metres):
    """Another lever arm: both cameras stand elsewhere on the IMU."""
    def change(mav0):
        for sensor in sensors(mav0):
            m = matrix(sensor)
            set_matrix(sensor, [[*row[:3], row[3] + by] for row, by in zip(m[:3], metres)] + [m[3]])
    return change


def in_millimetres(mav0):
    for sensor in sensors(mav0):
        m = matrix(sensor)
        set_matrix(sensor, [[*row[:3], 1000.0 * row[3]] for row in m[:3]] + [m[3]])


def turned_cameras(degrees):
    """Both cameras turned in cam0, about the IMU's z axis."""
    def change(mav0):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        R = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        centre = [row[3] for row in matrix(sensors(mav0)[0])[:3]]
        for sensor in sensors(mav0):
            m = matrix(sensor)
            about = [[*m[i][:3], m[i][3] - centre[i]] for i in range(3)]
            turned = [[sum(R[i][k] * about[k][j] for k in range(3)) for j in range(4)] for i in range(3)]
            set_matrix(sensor, [[*turned[i][:3], turned[i][3] + centre[i]] for i in range(3)] + [m[3]])
    return change


def intrinsics(change):
    def changed(mav0):
        for sensor in sensors(mav0):
            def other(found):
                values = [float(v) for v in found.group(2).split(",")]
                return found.group(1) + ", ".join(repr(v) for v in change(values)) + "]"
            sensor.write_text(re.sub(r"(intrinsics:\s*\[)(.*?)\]", other, sensor.read_text()))
    return changed


def turned_accelerometer(degrees):
    """About y."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def change(row):
        x, y, z = (float(v) for v in row[4:7])
        return [*row[:4], repr(c * x + s * z), repr(y), repr(c * z - s * x)]
    return lambda mav0: columns(mav0 / "imu0/data.csv", change)


def exchanged_axes(mav0):
    columns(mav0 / "imu0/data.csv", lambda row: [row[0], row[2], row[1], row[3], row[5], row[4], row[6]])


def halved(mav0):
    """As if calibrated at half the size."""
    for sensor in sensors(mav0):
        def half(found):
            return found.group(1) + ", ".join(repr(float(v) / 2) for v in found.group(2).split(",")) + "]"
        sensor.write_text(re.sub(r"(intrinsics:\s*\[)(.*?)\]", half, sensor.read_text()))


def rectified(mav0):
    """The calibration of rectified pictures."""
    for sensor in sensors(mav0):
        text = re.sub(r"distortion_model:.*", "distortion_model: none", sensor.read_text())
        sensor.write_text(re.sub(r"(?s)distortion_coefficients:\s*\[.*?\]", "distortion_coefficients: []", text))


def raw(mav0):
    """The calibration of raw pictures, for those of a lens that has no distortion."""
    for sensor in sensors(mav0):
        text = re.sub(r"distortion_model:.*", "distortion_model: radial-tangential", sensor.read_text())
        sensor.write_text(re.sub(r"(?s)distortion_coefficients:\s*\[.*?\]", "distortion_coefficients: [-0.28, 0.07, 0.0, 0.0]", text))


def right_late(mav0):
    """The right pixels (or pictures) are those of the frame before."""
    tracks = mav0 / "tracks0/data.csv"
    if not tracks.exists():
        rows = (mav0 / "cam1/data.csv").read_text().splitlines()
        header, pairs = rows[0], [row.split(",") for row in rows[1:] if row.strip()]
        late = [f"{now[0]},{before[1]}" for before, now in zip(pairs, pairs[1:])]
        (mav0 / "cam1/data.csv").write_text("\n".join([header, *late]) + "\n")
        return
    before, now, stamp = {}, {}, None

    def change(row):
        nonlocal before, now, stamp
        if row[0] != stamp:
            before, now, stamp = now, {}, row[0]
        now[row[1]] = row[4:6]
        return [*row[:4], *before.get(row[1], row[4:6])]

    columns(tracks, change)


def kitti_swapped(folder):
    """The pictures alone; `P0 and P1` below are the calibrations."""
    one, other, aside = folder / "image_0", folder / "image_1", folder / "aside"
    one.rename(aside), other.rename(one), aside.rename(other)


def kitti_projections(change):
    """Changes P0 and P1 of calib.txt, lists of three rows."""
    def changed(folder):
        lines = dict(line.split(":", 1) for line in (folder / "calib.txt").read_text().splitlines() if ":" in line)
        P = [[float(x) for x in lines[name].split()] for name in ("P0", "P1")]
        for name, values in zip(("P0", "P1"), change([[p[4 * i:4 * i + 4] for i in range(3)] for p in P])):
            lines[name] = " " + " ".join(repr(x) for row in values for x in row)
        (folder / "calib.txt").write_text("".join(f"{name}:{values}\n" for name, values in lines.items()))
    return changed


def kitti_right_late(folder):
    """But for the first, which has none before it."""
    pictures = sorted((folder / "image_1").iterdir())
    targets = [picture.readlink() for picture in pictures]
    for picture, target in zip(pictures[1:], targets):
        picture.unlink()
        picture.symlink_to(target)


MISTAKES = {
    "none": lambda mav0: None,
    "gyro in deg/s": imu(1, 4, 180.0 / math.pi),
    "accelerometer in g": imu(4, 7, 1.0 / 9.80665),
    "stamps of the IMU in s": imu_in_seconds,
    "IMU 20 ms late": imu_late(0.02),
    "IMU 0.1 s early": imu_late(-0.1),
    "gyro 1 % too much": imu(1, 4, 1.01),
    "accelerometer 1 % too much": imu(4, 7, 1.01),
    "accelerometer 2 % too much": imu(4, 7, 1.02),
    "accelerometer turned by 1.5 deg": turned_accelerometer(1.5),
    "x and y of the IMU exchanged": exchanged_axes,
    "IMU 5 cm away": shifted_cameras(0.05, 0.0, 0.0),
    "IMU 10 cm away": shifted_cameras(0.0, 0.1, 0.0),
    "IMU 20 cm away": shifted_cameras(0.2, 0.0, 0.0),
    "mount turned by 0.5 deg, beside the IMU": turned_cameras(0.5),
    "mount turned by 3 deg, beside the IMU": turned_cameras(3.0),
    "both principal points 2 px off, beside the IMU": intrinsics(lambda v: [v[0], v[1], v[2] + 2.0, v[3]]),
    "both principal points 5 px off, beside the IMU": intrinsics(lambda v: [v[0], v[1], v[2] + 5.0, v[3]]),
    "focal lengths 1 % too long, beside the IMU": intrinsics(lambda v: [1.01 * v[0], 1.01 * v[1], v[2], v[3]]),
    "T_BS in mm": in_millimetres,
    "cameras swapped": swapped,
    "T_BS of both cameras inverted": inverted((0, 1)),
    "T_BS of cam1 inverted": inverted((1,)),
    "calibrated at half the resolution": halved,
    "rectified calibration, raw pictures": rectified,
    "raw calibration, rectified pictures": raw,
    "right pictures a frame late": right_late,
}
KITTI_MISTAKES = {
    "none": lambda folder: None,
    "cameras swapped": kitti_swapped,
    "P0 and P1 exchanged": kitti_projections(lambda P: [P[1], P[0]]),
    "calibrated at half the resolution": kitti_projections(
        lambda P: [[[x / 2 for x in row] for row in p[:2]] + [p[2]] for p in P]),
    "right pictures a frame late": kitti_right_late,
}


def is_kitti(folder):
    return (folder / "calib.txt").exists()


def why_not(name, mav0):
    """Why this recording cannot have this mistake; nothing where it can."""
    of_imu = any(word in name for word in ("IMU", "gyro", "accelerometer"))
    if is_kitti(mav0):
        if name in KITTI_MISTAKES:
            return None
        return "it has no IMU" if of_imu else "calib.txt has no T_BS" if "T_BS" in name else "calib.txt has no distortion"
    if of_imu and not (mav0 / "imu0/data.csv").exists():
        return "it has no IMU"
    distorted = "distortion_model: none" not in sensors(mav0)[0].read_text()
    if name.startswith("rectified") and not distorted:
        return "it has no distortion"
    return "its pictures are raw" if name.startswith("raw") and distorted else None


def copy(recording, into):
    """Pictures are not changed, so links will do."""
    def link_or_copy(source, target):
        if pathlib.Path(source).suffix in (".csv", ".yaml", ".txt", ".json"):
            shutil.copyfile(source, target)
        else:
            os.symlink(pathlib.Path(source).resolve(), target)
    shutil.copytree(recording, into, copy_function=link_or_copy)
    return into / "mav0" if (into / "mav0").exists() else into


def judged(limber, folder):
    done = subprocess.run([limber, "health", folder, "--json"], capture_output=True, text=True)
    try:
        found = json.loads(done.stdout)
    except json.JSONDecodeError:
        return "refused", done.stderr.strip().splitlines()[-1]
    return found["verdict"], "; ".join(found["mistakes"])


def run(limber, method, folder):
    """Exit code, what is known of the run, and what was named."""
    out = folder.parent / "run"
    done = subprocess.run([limber, "run", folder, "--method", method, "--out", out], capture_output=True, text=True)
    if not (out / "summary.json").exists():
        return "refused", done.stderr.strip().splitlines()[-1]
    found = json.loads((out / "summary.json").read_text())
    ate, anees = (found["ate_m"] or {}).get("se3"), found["anees"]
    truth = f", {ate:.3g} m" if ate is not None else ""
    truth += f" (ANEES {anees:.1f})" if anees is not None else ""
    named = [note.removeprefix("looks like a mistake: ") for note in found["notes"] if note.startswith("looks like a mistake")]
    return f"exit {done.returncode}, {(found['health'] or {}).get('verdict', 'not judged')}{truth}", "; ".join(named)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+", type=pathlib.Path)
    parser.add_argument("--only", default="", help="mistakes whose names contain one of these")
    parser.add_argument("--run", metavar="METHOD", help="ask limber run by that method instead of limber health")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    arguments = parser.parse_args()
    limber = arguments.limber.resolve()
    print("| recording | mistake | verdict | named |\n| --- | --- | --- | --- |", flush=True)
    for recording in arguments.recordings:
        mistakes = {**MISTAKES, **KITTI_MISTAKES} if is_kitti(recording) else MISTAKES
        for name, make in mistakes.items():
            if not any(text in name for text in arguments.only.split(",")):
                continue
            with tempfile.TemporaryDirectory() as scratch:
                folder = pathlib.Path(scratch) / recording.name
                mav0 = copy(recording, folder)
                reason = why_not(name, mav0)
                if reason:
                    print(f"| {recording.name} | {name} | – | not made: {reason} |", flush=True)
                    continue
                make(mav0)
                verdict, named = run(limber, arguments.run, folder) if arguments.run else judged(limber, folder)
                print(f"| {recording.name} | {name} | {verdict} | {named.replace(str(folder), recording.name)} |", flush=True)


if __name__ == "__main__":
    main()
