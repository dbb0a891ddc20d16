# SPDX-License-Identifier: MIT
"""What the peers' harness reads of an EuRoC folder: stamps, sensor.yaml, IMU, truth. Standard library alone."""
import math
import pathlib
import re


class Malformed(Exception):
    """Names the file and what was expected."""


def rows(path, fewest):
    """Fields of a CSV file's lines, comments left out; at least `fewest` of them."""
    for number, line in enumerate(pathlib.Path(path).read_text().splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        fields = [field.strip() for field in line.split(",")]
        if len(fields) < fewest:
            raise Malformed(f"{path}:{number}: expected {fewest} fields, found {len(fields)}")
        yield fields


def stereo_stamps(recording):
    """Stamps [ns] that both cameras have, or those of a track log's frames; ascending."""
    tracks = recording / "mav0/tracks0/data.csv"
    if tracks.exists():
        return sorted({int(row[0]) for row in rows(tracks, 6)})
    return [t_ns for t_ns, _, _ in stereo_pairs(recording)]


def stereo_pairs(recording):
    """[(t [ns], left image, right image)] of the stamps that both cameras have, ascending."""
    left, right = ({int(row[0]): recording / f"mav0/{camera}/data" / row[1] for row in rows(recording / f"mav0/{camera}/data.csv", 2)}
                   for camera in ("cam0", "cam1"))
    return [(t_ns, left[t_ns], right[t_ns]) for t_ns in sorted(left.keys() & right.keys())]


def number_list(text, key, path):
    found = re.search(rf"^\s*{key}\s*:\s*\[([^\]]*)\]", text, re.M)
    if not found:
        raise Malformed(f"{path}: expected {key}: [numbers]")
    return [float(number) for number in re.split(r"[,\s]+", found.group(1).strip()) if number]


def word(text, key, path):
    found = re.search(rf"^\s*{key}\s*:\s*([^\s#]+)", text, re.M)
    if not found:
        raise Malformed(f"{path}: expected {key}")
    return found.group(1)


def camera(recording, name):
    """T_imu_cam (4 x 4), resolution, intrinsics, distortion model and coefficients of mav0/<name>/sensor.yaml."""
    path = recording / f"mav0/{name}/sensor.yaml"
    text = path.read_text()
    pose = number_list(text, "data", path)
    if len(pose) != 16:
        raise Malformed(f"{path}: expected 16 numbers in T_BS, found {len(pose)}")
    return {
        "T_imu_cam": [pose[4 * i:4 * i + 4] for i in range(4)],
        "resolution": [int(n) for n in number_list(text, "resolution", path)],
        "intrinsics": number_list(text, "intrinsics", path),
        "distortion_model": word(text, "distortion_model", path),
        "distortion_coefficients": number_list(text, "distortion_coefficients", path),
    }


NOISE = ("gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density", "accelerometer_random_walk")


def imu_noise(recording):
    """Densities of mav0/imu0/sensor.yaml. Its frame has to be the body's, as in EuRoC, since poses of the body are scored."""
    path = recording / "mav0/imu0/sensor.yaml"
    text = path.read_text()
    if number_list(text, "data", path) != [float(i % 5 == 0) for i in range(16)]:
        raise Malformed(f"{path}: expected the identity as T_BS")
    return {key: float(word(text, key, path)) for key in NOISE}


def imu(recording):
    """[(t [ns], (angular rate [rad/s]), (specific force [m/s^2]))]"""
    return [(int(row[0]), tuple(map(float, row[1:4])), tuple(map(float, row[4:7])))
            for row in rows(recording / "mav0/imu0/data.csv", 7)]


def truth(recording):
    """[(t [ns], p, q (w x y z, body to world), v, gyro bias or None, accelerometer bias or None)]"""
    states = []
    for row in rows(recording / "mav0/state_groundtruth_estimate0/data.csv", 11):
        values = list(map(float, row[1:]))
        biases = (values[10:13], values[13:16]) if len(values) >= 16 else (None, None)
        states.append((int(row[0]), values[0:3], values[3:7], values[7:10], *biases))
    return states


def product(a, b):
    """Of quaternions w x y z."""
    return [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]]


def conjugate(q):
    return [q[0], -q[1], -q[2], -q[3]]


def rotate(q, v):
    return product(product(q, [0, *v]), conjugate(q))[1:]


def rotation_vector(q):
    if q[0] < 0:
        q = [-x for x in q]
    sine = math.hypot(*q[1:])
    return [2 * math.atan2(sine, q[0]) * x / sine if sine > 0 else 0.0 for x in q[1:]]


def biases_from_truth(states, samples, gravity):
    """Mean of what the IMU measured less what the truth says, over the given stretch: (gyro, accelerometer)."""
    duration = 1e-9 * (states[-1][0] - states[0][0])
    samples = [s for s in samples if states[0][0] <= s[0] < states[-1][0]]
    if duration <= 0 or not samples:
        raise Malformed("no IMU samples where the truth begins")
    turned, forced = [0.0] * 3, [0.0] * 3
    for a, b in zip(states, states[1:]):
        turn = rotation_vector(product(conjugate(a[2]), b[2]))
        pull = [(w - u) + g * 1e-9 * (b[0] - a[0]) for u, w, g in zip(a[3], b[3], (0, 0, gravity))]
        push = rotate(conjugate(a[2]), pull)
        turned = [x + y for x, y in zip(turned, turn)]
        forced = [x + y for x, y in zip(forced, push)]
    mean = [[sum(s[k][i] for s in samples) / len(samples) for i in range(3)] for k in (1, 2)]
    return ([m - x / duration for m, x in zip(mean[0], turned)], [m - x / duration for m, x in zip(mean[1], forced)])
