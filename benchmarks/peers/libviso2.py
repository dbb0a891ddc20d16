# SPDX-License-Identifier: MIT
"""Files that libviso2_runner reads, made from a recording."""
import euroc
import recordings

MODELS = ("none", "radial-tangential", "radtan")


def inverse(T):
    """Of a rigid transformation, 4 x 4."""
    turned = [[T[j][i] for j in range(3)] for i in range(3)]
    return [[*row, -sum(r * T[k][3] for k, r in enumerate(row))] for row in turned] + [[0.0, 0.0, 0.0, 1.0]]


def product(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def is_rectified(cameras, T_cam1_cam0):
    """Rows correspond as the images are: no lens, one focal length, no turn, a baseline along the rows."""
    same = cameras[0]["intrinsics"] == cameras[1]["intrinsics"] and cameras[0]["intrinsics"][0] == cameras[0]["intrinsics"][1]
    lens = any(any(camera["distortion_coefficients"]) for camera in cameras)
    off = [T_cam1_cam0[i][j] - float(i == j) for i in range(3) for j in range(4) if (i, j) != (0, 3)]
    return same and not lens and max(map(abs, off)) < 1e-9


def matrix(name, rows):
    """Of OpenCV's YAML."""
    numbers = ", ".join(repr(float(x)) for row in rows for x in row)
    return f"{name}: !!opencv-matrix\n   rows: {len(rows)}\n   cols: {len(rows[0])}\n   dt: d\n   data: [{numbers}]\n"


def rig(cameras):
    """The calibration, as the runner reads it."""
    T_cam1_cam0 = product(inverse(cameras[1]["T_imu_cam"]), cameras[0]["T_imu_cam"])
    text = f"%YAML:1.0\n---\nrectified: {int(is_rectified(cameras, T_cam1_cam0))}\n"
    for i, camera in enumerate(cameras):
        if camera["distortion_model"] not in MODELS:
            raise euroc.Malformed(f"cam{i}: the rectifier has no {camera['distortion_model']}, expected {' or '.join(MODELS)}")
        fu, fv, cu, cv = camera["intrinsics"]
        coefficients = (list(camera["distortion_coefficients"]) + [0.0] * 4)[:max(4, len(camera["distortion_coefficients"]))]
        text += matrix(f"K{i}", [[fu, 0, cu], [0, fv, cv], [0, 0, 1]]) + matrix(f"distortion{i}", [coefficients])
    return text + matrix("T_cam1_cam0", T_cam1_cam0) + matrix("T_body_cam0", cameras[0]["T_imu_cam"])


def write_inputs(recording, folder):
    """Writes rig.yaml and pairs.tsv into a folder; returns their paths. Tabs, because names of bent recordings hold commas."""
    folder.mkdir(parents=True, exist_ok=True)
    calibration, pairs = folder / "rig.yaml", folder / "pairs.tsv"
    calibration.write_text(rig(recordings.cameras(recording)))
    pairs.write_text("".join(f"{t_ns}\t{left}\t{right}\n" for t_ns, left, right in recordings.stereo_pairs(recording)))
    return calibration, pairs
