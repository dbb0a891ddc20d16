# SPDX-License-Identifier: MIT
import numpy as np
import pytest

import limber

WIDTH, HEIGHT, DISPARITY = 320, 240, 8


@pytest.fixture
def tracker():
    camera = limber.Camera(200, 200, 160, 120, WIDTH, HEIGHT)
    return limber.StereoTracker(limber.StereoCalibration(camera, camera, [0, 0, 0, -0.2, 0, 0]), max_tracks=60)


def texture(shift=0):
    noise = np.random.default_rng(1).normal(size=(HEIGHT, WIDTH + 64))
    for axis in (0, 1):
        for _ in range(3):
            noise = (np.roll(noise, 1, axis) + noise + np.roll(noise, -1, axis)) / 3
    grey = 128 + 40 * noise / noise.std()
    return np.clip(grey, 0, 255).astype(np.uint8)[:, 20 + shift:20 + shift + WIDTH]


def test_images_in_memory_become_tracks_with_the_right_disparity(tracker):
    left, right = texture(), texture(DISPARITY)
    assert not left.flags.c_contiguous  # rows lie apart: used where they are
    for k in range(3):
        frame = tracker.process(k * 50_000_000, left, right)
    points = frame.observations[frame.observations["in_cam1"]]
    assert len(points) > 20
    disparity = points["uv_cam0"][:, 0] - points["uv_cam1"][:, 0]
    assert np.median(np.abs(disparity - DISPARITY)) < 0.1


def test_what_is_no_grey_image_of_that_size_is_refused(tracker):
    left = texture()
    for wrong in (left.astype(float), np.dstack([left] * 3), left[:, ::2]):
        with pytest.raises((TypeError, ValueError)):
            tracker.process(0, left, wrong)
    with pytest.raises(ValueError):
        tracker.process(0, left, np.ascontiguousarray(left[:100]))
