# SPDX-License-Identifier: MIT
import threading

import numpy as np
import pytest

import limber

METHODS = ["lcekf", "adaptive", "mono-left"] + [
    pytest.param(method, marks=pytest.mark.full) for method in ("ekf", "ekf-full", "soft", "consider")]


def step_through(recording, **options):
    """What limber.run does, by hand; positions after the start, and the navigator."""
    navigator_options, calibration, _ = limber.set_up(recording, limber.RunOptions(recording, **options))
    cleaner = limber.FrameCleaner(calibration)
    frames = [cleaner.clean(frame) for frame in limber.frames(recording)]
    t_imu = recording.imu["t_ns"]

    def feed(receiver, begin, t_ns):
        end = int(np.searchsorted(t_imu, t_ns + receiver.clock_offset_ns)) + 1
        receiver.add_imu(recording.imu[begin:end])
        return min(end, len(t_imu))

    start, begin, used = limber.SensorStart(calibration, navigator_options), 0, 0
    report = None
    while report is None or report.status == "waiting":
        begin = feed(start, begin, frames[used].t_ns)
        report = start.add_frame(frames[used])
        used += 1
    navigator, begin, states = limber.Navigator(calibration, start.result(), navigator_options), 0, []
    for frame in frames[used:]:
        begin = feed(navigator, begin, frame.t_ns)
        navigator.process(frame)
        states.append(navigator.estimate())
    return states, navigator


@pytest.mark.parametrize("method", METHODS)
def test_step_by_step_is_the_run_bit_by_bit(recording, method):
    run = limber.run(recording, method)
    states, navigator = step_through(recording, method=method)
    n = len(states)
    assert n > 30
    assert np.array_equal([state.p for state in states], run.p[-n:])
    assert np.array_equal([state.R for state in states], run.R[-n:])
    assert np.array_equal([state.covariance[:6, :6] for state in states], run.covariance[-n:])
    ids, positions = navigator.landmarks()
    assert {i: tuple(p) for i, p in zip(ids.tolist(), positions)} == {i: tuple(p) for i, p in run.landmarks.items()}


def step_through_online(recording, navigator):
    """Positions since the start, and the reports of all frames, as an application has them."""
    _, calibration, _ = limber.set_up(recording, limber.RunOptions(recording))
    cleaner, t_imu, begin = limber.FrameCleaner(calibration), recording.imu["t_ns"], 0
    reports, states = [], []
    for frame in limber.frames(recording):
        end = int(np.searchsorted(t_imu, frame.t_ns)) + 1
        navigator.add_imu(recording.imu[begin:end])
        begin = end
        reports.append(navigator.process(cleaner.clean(frame)))
        if navigator.started:
            states.append(navigator.estimate())
    return reports, states


def test_online_is_the_run_bit_by_bit_and_says_what_it_waits_for(recording):
    run = limber.run(recording)
    options, calibration, _ = limber.set_up(recording, limber.RunOptions(recording))
    navigator = limber.OnlineNavigator(calibration, options)
    reports, states = step_through_online(recording, navigator)
    after = sum(report.frame is not None for report in reports)
    assert after > 30 and after == len(states) - 1
    assert np.array_equal([state.p for state in states[1:]], run.p[-after:])
    assert np.array_equal([state.covariance[:6, :6] for state in states[1:]], run.covariance[-after:])
    waiting = reports[:-after - 1]
    assert waiting and all(report.start.status == "waiting" and report.start.missing for report in waiting)
    assert reports[-after - 1].start.status == "ready" and reports[-1].start is None
    navigator.reset()
    assert not navigator.started and navigator.health is None
    _, again = step_through_online(recording, navigator)
    assert np.array_equal([state.p for state in again], [state.p for state in states])


def test_online_refuses_what_is_out_of_order_and_has_no_state_before_the_start(calibration):
    navigator = limber.OnlineNavigator(calibration, limber.NavigatorOptions(), shortest_s=0.5)
    with pytest.raises(RuntimeError, match="no start yet"):
        navigator.estimate()
    assert "IMU samples" in navigator.process(limber.StereoFrame(10**9, [], np.zeros((0, 2)), np.zeros((0, 2)))).start.missing
    navigator.add_imu(10**9, [0, 0, 0], [0, 0, 9.81])
    with pytest.raises(ValueError, match="does not come after"):
        navigator.add_imu(10**9, [0, 0, 0], [0, 0, 9.81])
    navigator.reset(limber.InitialState())
    assert navigator.started
    report = at_rest(navigator)
    assert report.start is None and report.frame.used == 20
    assert np.linalg.norm(navigator.predict(navigator.estimate().t_ns + 10**7).p) < 0.01


def at_rest(navigator, seconds=1.0, first_ms=0):
    """A wall before a rig that does not move."""
    camera, calibration = navigator.calibration.cam0, navigator.calibration
    X = np.array([[k % 5 - 2.0, k // 5 - 1.5, 6.0 + k % 3] for k in range(20)])
    right = limber.pose_from_rig(calibration.theta)
    uv0 = [camera.project(x) for x in X]
    uv1 = [camera.project(right.R @ x + right.p) for x in X]
    for ms in range(first_ms, first_ms + int(1000 * seconds) + 1, 5):
        navigator.add_imu(ms * 10**6, [0, 0, 0], [0, 0, 9.81])
        if ms % 50 == 0:
            report = navigator.process(limber.StereoFrame(ms * 10**6, range(20), uv0, uv1))
    return report


@pytest.fixture
def calibration():
    camera = limber.Camera(455, 455, 376, 240, 752, 480)
    looking_forward = limber.Pose([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    return limber.StereoCalibration(camera, camera, [0, 0, 0, -0.12, 0, 0], T_body_cam0=looking_forward)


def test_a_rig_at_rest_stays_and_predict_goes_on_between_frames(calibration):
    navigator = limber.Navigator(calibration, limber.InitialState(), limber.NavigatorOptions())
    report = at_rest(navigator)
    assert report.status == "updated" and report.used == 20 and report.inputs == "sound"
    state = navigator.estimate()
    assert np.linalg.norm(state.p) < 0.01 and state.covariance.shape == (15, 15)
    later = navigator.predict(state.t_ns + 5_000_000)
    assert later.t_ns == state.t_ns + 5_000_000
    assert later.covariance[0, 0] > state.covariance[0, 0]
    assert np.array_equal(navigator.estimate().p, state.p)
    assert np.allclose(state.q_wxyz, [1, 0, 0, 0], atol=1e-2)


def test_reset_begins_anew(calibration):
    navigator = limber.Navigator(calibration, limber.InitialState(), limber.NavigatorOptions())
    at_rest(navigator)
    first = navigator.estimate()
    navigator.reset(limber.InitialState())
    assert navigator.estimate().t_ns == 0 and len(navigator.landmarks()[0]) == 0
    at_rest(navigator)
    assert np.array_equal(navigator.estimate().p, first.p)


def test_what_is_estimated_has_a_name_a_value_and_a_sigma(calibration):
    options = limber.NavigatorOptions(method="ekf", estimated={"dt1": 0.002})
    navigator = limber.Navigator(calibration, limber.InitialState(), options)
    at_rest(navigator)
    (error, sigma), = navigator.calibration_estimate().values()
    assert abs(error) < 3 * sigma and sigma == pytest.approx(0.002, rel=0.1)


def test_the_library_s_complaints_are_exceptions(calibration):
    with pytest.raises(ValueError, match="lcekf"):
        limber.NavigatorOptions(method="kalman")
    with pytest.raises(ValueError, match="estimated: expected names"):
        limber.NavigatorOptions(estimated={"warp": 1.0})
    navigator = limber.Navigator(calibration, limber.InitialState(), limber.NavigatorOptions())
    navigator.add_imu(10**9, [0, 0, 0], [0, 0, 9.81])
    with pytest.raises(ValueError):
        navigator.add_imu(10**9, [0, 0, 0], [0, 0, 9.81])
    with pytest.raises(ValueError, match="samples: expected rows of"):
        navigator.add_imu(np.zeros(3))


def test_two_threads_do_not_trip_over_one_navigator(calibration):
    navigator = limber.Navigator(calibration, limber.InitialState(), limber.NavigatorOptions())
    done = threading.Event()

    def look():
        while not done.is_set():
            assert np.isfinite(navigator.estimate().covariance).all()
            navigator.landmarks()

    reader = threading.Thread(target=look)
    reader.start()
    report = at_rest(navigator)
    done.set()
    reader.join()
    assert report.status == "updated"
