# SPDX-License-Identifier: MIT
"""What the peers' harness reads of a KITTI odometry folder: stamps, image pairs, calib.txt. Standard library alone."""
import euroc


def is_kitti(recording):
    return (recording / "calib.txt").exists()


def stamps(recording):
    """Of all frames [ns], as times.txt has them."""
    return [round(1e9 * float(line)) for line in (recording / "times.txt").read_text().split()]


def stereo_pairs(recording):
    """[(t [ns], left image, right image)] of the frames that both cameras have."""
    times = stamps(recording)
    right = {path.name: path for path in (recording / "image_1").iterdir()}
    pairs = [(path, right[path.name]) for path in sorted((recording / "image_0").iterdir()) if path.name in right]
    for left, _ in pairs:
        if int(left.stem) >= len(times):
            raise euroc.Malformed(f"{recording / 'times.txt'}: expected a time for {left.name}, found {len(times)}")
    return [(times[int(left.stem)], left, right) for left, right in pairs]


def projection(text, key, path):
    for line in text.splitlines():
        if line.startswith(f"{key}:"):
            numbers = [float(word) for word in line.split()[1:]]
            if len(numbers) == 12:
                return numbers
    raise euroc.Malformed(f"{path}: expected {key}: and 12 numbers")


def camera(recording, name):
    """cam0 or cam1 as euroc.camera gives it: the left camera is the body, images are rectified."""
    path = recording / "calib.txt"
    p = projection(path.read_text(), "P" + name[-1], path)
    return {
        "T_imu_cam": [[1.0, 0.0, 0.0, -p[3] / p[0]], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
        "intrinsics": [p[0], p[5], p[2], p[6]], "distortion_model": "none", "distortion_coefficients": [],
    }
