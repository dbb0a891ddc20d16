# SPDX-License-Identifier: MIT
import shutil
import struct
import zlib

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


def png(pixels):
    height, width = pixels.shape

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


@pytest.fixture
def folder_of_images(tracker, tmp_path):
    """Five pairs; the right image of the third is torn."""
    camera = limber.Camera(200, 200, 160, 120, WIDTH, HEIGHT)
    calibration = limber.StereoCalibration(camera, camera, [0, 0, 0, -0.2, 0, 0])
    empty = limber.StereoFrame(0, np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros((0, 2)))
    limber.Recording(calibration, [empty]).write(tmp_path)
    shutil.rmtree(tmp_path / "mav0" / "tracks0")
    for name, pixels in (("cam0", texture()), ("cam1", texture(DISPARITY))):
        data = tmp_path / "mav0" / name / "data"
        data.mkdir()
        for k in range(5):
            (data / f"{k}.png").write_bytes(png(pixels)[:-500 if (name, k) == ("cam1", 2) else None])
        (data.parent / "data.csv").write_text(
            "#timestamp [ns],filename\n" + "".join(f"{k * 50_000_000},{k}.png\n" for k in range(5)))
    return tmp_path


def test_images_that_cannot_be_read_are_a_frame_without_points_and_a_warning(folder_of_images):
    recording = limber.read(folder_of_images)
    with pytest.warns(RuntimeWarning, match=r"at 100000000 ns: .*cam1/data/2.png") as warned:
        frames = list(limber.frames(recording))
    assert len(warned) == 1
    assert [frame.t_ns for frame in frames] == [k * 50_000_000 for k in range(5)]
    assert [len(frame.observations) > 20 for frame in frames] == [True, True, False, True, True]
    assert len(frames[2].observations) == 0
    last = frames[3].observations["track_id"]
    assert len(np.intersect1d(last, frames[1].observations["track_id"])) > 20  # tracks go on


def test_recordings_of_nothing_but_torn_images_are_refused(folder_of_images):
    for torn in (folder_of_images / "mav0" / "cam0" / "data").iterdir():
        torn.write_bytes(torn.read_bytes()[:-500])
    with pytest.warns(RuntimeWarning), pytest.raises(limber.DataError, match="cut off"):
        list(limber.frames(limber.read(folder_of_images)))
