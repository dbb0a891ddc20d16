# SPDX-License-Identifier: MIT
"""Files that OpenVINS reads, made from one of its own folders of settings and from a recording."""
import math
import re
import statistics

import euroc

CALIBRATION = ("calib_cam_extrinsics", "calib_cam_intrinsics", "calib_cam_timeoffset")
IMU_CALIBRATION = ("calib_imu_intrinsics", "calib_imu_g_sensitivity")
MODELS = {"none": "radtan", "radial-tangential": "radtan", "radtan": "radtan", "equidistant": "equidistant"}


def with_settings(text, settings):
    """The estimator_config.yaml with these values; a key that it does not have is an error."""
    for key, value in settings.items():
        text, found = re.subn(rf"^{key}:[^#\n]*", f"{key}: {value} ", text, count=1, flags=re.M)
        if not found:
            raise euroc.Malformed(f"estimator_config.yaml: expected {key}")
    return text


def setting(text, key):
    return euroc.word(text, key, "estimator_config.yaml")


def changes(text, calibrate, start, points):
    """What differs from OpenVINS' own settings, all of it."""
    changed = {"num_opencv_threads": 0}  # serial: its own advice for results that repeat
    changed.update({key: "false" for key in IMU_CALIBRATION if re.search(rf"^{key}: *true", text, re.M)})
    if not calibrate:
        changed.update({key: "false" for key in CALIBRATION})
    if points:
        changed["num_pts"] = 2 * points  # OpenVINS divides by the number of cameras
    if start == "truth":
        changed["init_max_features"] = changed.get("num_pts", setting(text, "num_pts"))  # kept after a start from the truth
    else:
        changed["init_dyn_use"] = "true"  # a recording may begin in motion
    return changed


def camchain(cameras):
    """kalibr_imucam_chain.yaml of two cameras, as euroc.camera reads them."""
    lines = ["%YAML:1.0", ""]
    for i, camera in enumerate(cameras):
        if camera["distortion_model"] not in MODELS:
            raise euroc.Malformed(f"cam{i}: OpenVINS has no {camera['distortion_model']}, expected {' or '.join(MODELS)}")
        if any(camera["distortion_coefficients"][4:]):
            raise euroc.Malformed(f"cam{i}: OpenVINS has four distortion coefficients, found more")
        coefficients = ([float(x) for x in camera["distortion_coefficients"]] + [0.0] * 4)[:4]
        lines += [f"cam{i}:", "  T_imu_cam:"]
        lines += [f"    - [{', '.join(repr(float(x)) for x in row)}]" for row in camera["T_imu_cam"]]
        lines += [f"  cam_overlaps: [{1 - i}]", "  camera_model: pinhole",
                  f"  distortion_coeffs: {coefficients}",
                  f"  distortion_model: {MODELS[camera['distortion_model']]}",
                  f"  intrinsics: {[float(x) for x in camera['intrinsics']]}", f"  resolution: {camera['resolution']}",
                  f"  rostopic: /cam{i}/image_raw"]
    return "\n".join(lines) + "\n"


LEAST_WALK = 1e-5  # rad/s^2/sqrt(Hz), m/s^3/sqrt(Hz): its initializer inverts the covariance of the biases


def imu_chain(noise):
    """kalibr_imu_chain.yaml: these densities, walks no smaller than LEAST_WALK, no scale or misalignment."""
    noise = {key: max(value, LEAST_WALK) if key.endswith("walk") else value for key, value in noise.items()}
    lines = ["%YAML:1.0", "", "imu0:"]
    lines += [f"  {key}: {value!r}" for key, value in noise.items()]
    lines += ["  rostopic: /imu0", "  time_offset: 0.0", "  update_rate: 200.0", '  model: "kalibr"']
    for key in ("Tw", "R_IMUtoGYRO", "Ta", "R_IMUtoACC", "Tg"):
        lines += [f"  {key}:"] + [f"    - {[float(i == j and key != 'Tg') for j in range(3)]}" for i in range(3)]
    return "\n".join(lines) + "\n"


def start(recording, gravity):
    """17 numbers for initialize_with_gt: the truth at or before the first image; biases of the truth, else of its first second."""
    states, first = euroc.truth(recording), euroc.stereo_stamps(recording)[0]
    k = max([i for i, state in enumerate(states) if state[0] <= first], default=0)
    t_ns, p, q, v, gyro, accelerometer = states[k]
    if gyro is None:
        second = [state for state in states[k:] if state[0] <= t_ns + 1_000_000_000]
        gyro, accelerometer = euroc.biases_from_truth(second, euroc.imu(recording), gravity)
    return [1e-9 * t_ns, q[1], q[2], q[3], q[0], *p, *v, *gyro, *accelerometer]


# What OpenVINS writes of a frame [s]: stamp, tracking, the steps of its filter, marginalisation with the triangulation of all
# tracks for its display, all of it.
TIMES = "times.txt"


def split(folder):
    """{"track_ms", "filter_ms"}: p50 and p99 over the frames that it updated with, on the clock, without what serves its display;
    None where there are none."""
    path = folder / TIMES
    frames = [list(map(float, row)) for row in euroc.rows(path, 4)] if path.exists() else []
    if not frames:
        return None
    return {"track_ms": quantiles([1e3 * row[1] for row in frames]),
            "filter_ms": quantiles([1e3 * (row[-1] - row[1] - row[-2]) for row in frames])}


def quantiles(values):
    """p50, and the p99 that is one of the values."""
    return {"p50": statistics.median(values), "p99": sorted(values)[math.ceil(0.99 * len(values)) - 1]}


def write_settings(settings, recording, folder, calibrate, start_from, points):
    """Writes what a run needs into a folder, from a folder of OpenVINS' settings; returns (estimator config, start file
    or None, changes)."""
    folder.mkdir(parents=True, exist_ok=True)
    text = (settings / "estimator_config.yaml").read_text()
    changed = changes(text, calibrate, start_from, points)
    changed.update({"record_timing_information": "true", "record_timing_filepath": f'"{folder / TIMES}"'})
    config = folder / "estimator_config.yaml"
    config.write_text(with_settings(text, changed))
    (folder / "kalibr_imucam_chain.yaml").write_text(camchain([euroc.camera(recording, f"cam{i}") for i in range(2)]))
    (folder / "kalibr_imu_chain.yaml").write_text(imu_chain(euroc.imu_noise(recording)))
    if start_from != "truth":
        return config, None, changed
    state = folder / "start.txt"
    state.write_text(" ".join(f"{x:.17g}" for x in start(recording, float(setting(text, "gravity_mag")))) + "\n")
    return config, state, changed
