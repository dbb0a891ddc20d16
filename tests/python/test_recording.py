# SPDX-License-Identifier: MIT
import gc
import pathlib

import numpy as np
import pytest

import limber
from conftest import short


def test_arrays_are_views_of_the_recording(recording):
    for array in (recording.imu, recording.truth_p, recording.truth_R, recording.frames[0].observations):
        assert not array.flags.owndata and not array.flags.writeable
    assert np.shares_memory(recording.imu, recording.imu)
    assert np.shares_memory(recording.truth_p, recording.truth_p)


def test_views_outlive_the_name_of_their_recording():
    recording = short("drone_none", 1.0)
    p, points = recording.truth_p, recording.frames[3].observations
    p_then, points_then = p.copy(), points.copy()
    del recording
    gc.collect()
    np.zeros(10**6)
    assert np.array_equal(p, p_then) and np.array_equal(points, points_then)


def test_a_bag_that_was_cut_off_is_partial(tmp_path):
    bags = pathlib.Path(__file__).parents[1] / "bags" / "fixtures"
    calib = str(bags / "camchain.yaml")
    assert not limber.read(str(bags / "ros1_none.bag"), calib=calib).partial
    cut = tmp_path / "cut.bag"
    cut.write_bytes((bags / "ros1_none.bag").read_bytes()[:40000])
    recording = limber.read(str(cut), calib=calib)
    assert recording.partial and any("bytes are left out" in note for note in recording.notes)


def test_rotations_are_rotations(recording):
    R = recording.truth_R
    assert np.allclose(R @ R.transpose(0, 2, 1), np.eye(3)) and np.allclose(np.linalg.det(R), 1)
    # The velocity of the truth, turned into the body, is what the body frame's x, y, z say: R is not transposed.
    camera = recording.calibration.cam0
    frame, row = recording.frames[20], None
    for row, t in enumerate(recording.truth_t_ns):
        if t == frame.t_ns:
            break
    T_body_cam0 = recording.calibration.T_body_cam0
    seen = frame.observations[frame.observations["in_cam0"]]
    errors = []
    for point in seen:
        X = R[row].T @ (recording.landmarks_true[int(point["track_id"])] - recording.truth_p[row])
        errors.append(camera.project(T_body_cam0.R.T @ (X - T_body_cam0.p)) - point["uv_cam0"])
    assert np.sqrt(np.mean(np.square(errors))) < 3.0


def test_the_same_seed_is_the_same_recording_and_another_is_not(recording):
    again, other = short("drone_constant"), short("drone_constant", seed=2)
    assert np.array_equal(again.imu, recording.imu)
    assert not np.array_equal(other.imu["accel"], recording.imu["accel"])


def test_a_track_log_comes_back(recording, tmp_path):
    recording.write(tmp_path)
    back = limber.read(tmp_path)
    assert np.array_equal(back.imu, recording.imu)
    assert len(back) == len(recording)
    assert np.array_equal(back.frames[-1].observations, recording.frames[-1].observations)
    with pytest.raises(limber.DataError, match="a recording that limber wrote"):
        recording.write(tmp_path)
    recording.write(tmp_path, force=True)


def test_the_readout_time_may_be_given(recording, tmp_path):
    recording.write(tmp_path)
    assert limber.read(tmp_path).calibration.readout_time_s == [0.0, 0.0]
    assert limber.read(tmp_path, readout_time=-0.02).calibration.readout_time_s == [-0.02, -0.02]
    for wrong in (0.2, float("nan")):
        with pytest.raises(ValueError, match="readout_time: expected a number from -0.1 to 0.1"):
            limber.read(tmp_path, readout_time=wrong)


def test_a_recording_from_memory_runs_as_the_one_it_was_made_of(recording, run):
    copy = limber.Recording(recording.calibration, list(recording.frames))
    copy.set_imu(recording.imu["t_ns"], recording.imu["omega"], recording.imu["accel"])
    copy.imu_noise, copy.pixel_noise = recording.imu_noise, recording.pixel_noise
    assert np.array_equal(limber.run(copy).p, run.p)


def test_a_frame_from_arrays_knows_what_each_camera_saw():
    nan = np.nan
    frame = limber.StereoFrame(7, [4, 5, 6], [[1, 2], [nan, nan], [3, 4]], [[1, 2], [5, 6], [nan, nan]])
    assert frame.t_ns == 7 and len(frame) == 3
    assert frame.observations["in_cam0"].tolist() == [True, False, True]
    assert frame.observations["in_cam1"].tolist() == [True, True, False]
    assert frame.observations["uv_cam1"][1].tolist() == [5, 6]


def test_wrong_shapes_and_points_that_nobody_saw_are_refused():
    with pytest.raises(ValueError, match=r"uv_cam1: expected shape \(1, 2\), found \(2, 2\)"):
        limber.StereoFrame(0, [1], [[1, 2]], [[1, 2], [3, 4]])
    with pytest.raises(ValueError, match="point 9: expected a pixel in one camera"):
        limber.StereoFrame(0, [9], [[np.nan, 1]], [[np.nan, 1]])


def test_errors_keep_the_library_s_text(tmp_path):
    with pytest.raises(limber.DataError, match="expected") as raised:
        limber.read(tmp_path / "nothing")
    assert raised.value.file == str(tmp_path / "nothing") and raised.value.line == 0
    with pytest.raises(ValueError, match="expected a file .* found 'paper_vi'"):
        limber.simulate("paper_vi")


def test_changes_to_a_scenario_take_effect():
    plain = short("drone_none", 1.0)
    assert len(short("drone_none", 1.0, imu=False).imu) == 0
    assert len(short("drone_none", 1.0, faults=["imu-gap=0.2:0.5"]).imu) < len(plain.imu)
    realistic = short("drone_none", 1.0, pixels="realistic")
    assert plain.pixel_noise is not None and realistic.pixel_noise is None
