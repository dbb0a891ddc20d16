# SPDX-License-Identifier: MIT
"""Images in, tracks out: NumPy images of a stereo pair become matched points, without copies."""
import numpy as np

import limber

camera = limber.Camera(fu=200, fv=200, cu=160, cv=120, width=320, height=240)
calibration = limber.StereoCalibration(camera, camera, theta=[0, 0, 0, -0.2, 0, 0])
tracker = limber.StereoTracker(calibration, max_tracks=80)

# A textured wall that drifts to the left, 8 px of disparity: in place of your camera driver.
wall = np.kron(np.random.default_rng(7).integers(0, 255, (30, 60)), np.ones((8, 8))).astype(np.uint8)
for k in range(5):
    left, right = wall[:, 40 + k:360 + k], wall[:, 48 + k:368 + k]
    frame = tracker.process(k * 50_000_000, left, right)

points = frame.observations[frame.observations["in_cam1"]]
disparity = points["uv_cam0"][:, 0] - points["uv_cam1"][:, 0]
print(f"{len(frame)} points, {len(points)} of them in both images, disparity {np.median(disparity):.2f} px")
assert abs(np.median(disparity) - 8) < 0.1
