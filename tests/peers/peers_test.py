#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""benchmarks/peers without a peer: files written for it, its start from the truth, causal poses, the tables."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "benchmarks/peers"))
import compare_peers  # noqa: E402
import compare_simulator  # noqa: E402
import draw_peers  # noqa: E402
import euroc  # noqa: E402
import kitti  # noqa: E402
import libviso2  # noqa: E402
import openvins  # noqa: E402
import peers_table  # noqa: E402
import recordings  # noqa: E402

CONFIG = """%YAML:1.0
calib_cam_extrinsics: true # says what
calib_cam_intrinsics: true
calib_cam_timeoffset: true
init_max_features: 50
init_dyn_use: false # if
init_dyn_use_more: 1
num_pts: 200 # points
num_opencv_threads: 4
gravity_mag: 9.81 # here
"""
SENSOR = """# comment
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.1,
         1.0, 0.0, 0.0, 0.2,
         0.0, 0.0, 1.0, 0.3,
         0.0, 0.0, 0.0, 1.0]
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.5, 457.0, 367.0, 248.0] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]
"""


def write(folder, path, text):
    file = pathlib.Path(folder) / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


def turning_recording(folder, gyro_bias, accelerometer_bias, biases_in_truth=False):
    """A rig on a circle of 2 m, a turn in 10 s, tilted by 30 degrees about its own x; sensors are exact but for the biases."""
    rate, radius = 2 * math.pi / 10, 2.0
    tilt = [math.cos(math.pi / 12), math.sin(math.pi / 12), 0, 0]
    truth, imu = [], []
    for k in range(401):
        t_ns, angle = 10**18 + 5_000_000 * k, rate * 0.005 * k
        q = euroc.product([math.cos(angle / 2), 0, 0, math.sin(angle / 2)], tilt)
        p = [radius * math.cos(angle), radius * math.sin(angle), 0]
        v = [-radius * rate * math.sin(angle), radius * rate * math.cos(angle), 0]
        force = [-radius * rate**2 * math.cos(angle), -radius * rate**2 * math.sin(angle), 9.81]
        w = [x + b for x, b in zip(euroc.rotate(euroc.conjugate(q), [0, 0, rate]), gyro_bias)]
        a = [x + b for x, b in zip(euroc.rotate(euroc.conjugate(q), force), accelerometer_bias)]
        columns = [*p, *q, *v, *([1, 2, 3, 4, 5, 6] if biases_in_truth else [])]
        truth.append(f"{t_ns}," + ",".join(map(repr, columns)))
        imu.append(f"{t_ns}," + ",".join(map(repr, w + a)))
    write(folder, "mav0/state_groundtruth_estimate0/data.csv", "# t\n" + "\n".join(truth) + "\n")
    write(folder, "mav0/imu0/data.csv", "# t\n" + "\n".join(imu) + "\n")
    stamps = "# t\n" + "".join(f"{10**18 + 52_000_000 * k},{k}.png\n" for k in range(1, 9))
    write(folder, "mav0/cam0/data.csv", stamps)
    write(folder, "mav0/cam1/data.csv", stamps.replace("\n1000000000104000000,2.png", ""))
    return pathlib.Path(folder)


class Settings(unittest.TestCase):
    def test_a_value_changes_and_nothing_else(self):
        self.assertEqual(openvins.with_settings(CONFIG, {"init_dyn_use": "true"}),
                         CONFIG.replace("init_dyn_use: false ", "init_dyn_use: true "))

    def test_a_key_that_is_not_there_is_an_error(self):
        with self.assertRaisesRegex(euroc.Malformed, "num_points"):
            openvins.with_settings(CONFIG, {"num_points": 1})

    def test_calibration_is_switched_off_all_of_it_or_left_as_it_is(self):
        self.assertEqual([openvins.changes(CONFIG, False, "own", None).get(key) for key in openvins.CALIBRATION], ["false"] * 3)
        self.assertFalse(set(openvins.CALIBRATION) & set(openvins.changes(CONFIG, True, "own", None)))

    def test_calibration_of_the_imu_is_off_in_every_row(self):
        config = CONFIG + "calib_imu_intrinsics: true # if\ncalib_imu_g_sensitivity: false\n"
        for calibrate in (True, False):
            changed = openvins.changes(config, calibrate, "truth", None)
            self.assertEqual([changed.get(key) for key in openvins.IMU_CALIBRATION], ["false", None])

    def test_points_after_a_start_from_the_truth_are_those_of_the_estimator(self):
        self.assertEqual(openvins.changes(CONFIG, True, "truth", None)["init_max_features"], "200")
        self.assertEqual(openvins.changes(CONFIG, True, "truth", 120)["init_max_features"], 240)
        self.assertEqual(openvins.changes(CONFIG, True, "truth", 120)["num_pts"], 240)
        self.assertEqual(openvins.changes(CONFIG, True, "own", None)["init_dyn_use"], "true")


class Calibration(unittest.TestCase):
    def test_sensor_yaml_becomes_a_camchain(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("cam0", "cam1"):
                write(folder, f"mav0/{name}/sensor.yaml", SENSOR)
            chain = openvins.camchain([euroc.camera(pathlib.Path(folder), name) for name in ("cam0", "cam1")])
        self.assertIn("cam1:\n  T_imu_cam:\n    - [0.0, -1.0, 0.0, 0.1]\n    - [1.0, 0.0, 0.0, 0.2]\n", chain)
        self.assertIn("  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n  distortion_model: radtan\n", chain)
        self.assertIn("  intrinsics: [458.5, 457.0, 367.0, 248.0]\n  resolution: [752, 480]\n", chain)

    def test_no_distortion_is_radial_tangential_with_zeros(self):
        sensor = SENSOR.replace("radial-tangential", "none").replace("[-0.28, 0.07, 0.0002, 1.7e-05]", "[]")
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "mav0/cam0/sensor.yaml", sensor)
            chain = openvins.camchain([euroc.camera(pathlib.Path(folder), "cam0")])
        self.assertIn("  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n", chain)

    def test_a_lens_the_peer_lacks_is_an_error(self):
        for old, new, expected in (("radial-tangential", "double-sphere", "double-sphere"), ("1.7e-05]", "0, 0.1]", "four")):
            with tempfile.TemporaryDirectory() as folder:
                write(folder, "mav0/cam0/sensor.yaml", SENSOR.replace(old, new))
                with self.assertRaisesRegex(euroc.Malformed, expected):
                    openvins.camchain([euroc.camera(pathlib.Path(folder), "cam0")])

    def test_biases_that_do_not_walk_walk_a_little(self):
        chain = openvins.imu_chain(dict(zip(euroc.NOISE, (1e-4, 0.0, 2e-3, 3e-3))))
        self.assertIn(f"  gyroscope_random_walk: {openvins.LEAST_WALK!r}\n", chain)
        self.assertIn("  accelerometer_random_walk: 0.003\n", chain)

    def test_an_imu_away_from_the_body_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "mav0/imu0/sensor.yaml", SENSOR + "".join(f"{key}: 1e-3\n" for key in euroc.NOISE))
            with self.assertRaisesRegex(euroc.Malformed, "identity"):
                euroc.imu_noise(pathlib.Path(folder))


class Start(unittest.TestCase):
    def test_biases_come_from_the_first_second_where_the_truth_has_none(self):
        gyro, accelerometer = [0.01, -0.02, 0.08], [0.1, -0.2, 0.05]
        with tempfile.TemporaryDirectory() as folder:
            state = openvins.start(turning_recording(folder, gyro, accelerometer), 9.81)
        self.assertAlmostEqual(state[0], 1e9 + 0.05, places=6)  # the truth at or before the first image, 2 ms later
        angle = 2 * math.pi / 10 * 0.05
        self.assertAlmostEqual(state[5], 2 * math.cos(angle))
        self.assertAlmostEqual(state[4], math.cos(angle / 2) * math.cos(math.pi / 12))  # w comes last
        for found, true in zip(state[11:], gyro + accelerometer):
            self.assertAlmostEqual(found, true, delta=3e-3)

    def test_biases_of_the_truth_are_taken(self):
        with tempfile.TemporaryDirectory() as folder:
            state = openvins.start(turning_recording(folder, [0] * 3, [0] * 3, biases_in_truth=True), 9.81)
        self.assertEqual(state[11:], [1, 2, 3, 4, 5, 6])


class Results(unittest.TestCase):
    def test_pairs_are_stamps_of_both_cameras(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(len(euroc.stereo_stamps(turning_recording(folder, [0] * 3, [0] * 3))), 7)

    def test_poses_that_were_smoothed_are_left_out(self):
        rows = "t_ns,px [m]\n" + "".join(f"{100 * 10**9 + 500_000_000 * k},0\n" for k in range(6))
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "trajectory.csv", rows)
            self.assertEqual(compare_peers.limber_poses(pathlib.Path(folder), 100 * 10**9), [])  # no summary: not done
            for start, left in (({"waited_s": 1.0}, 4), (None, 6)):
                write(folder, "summary.json", json.dumps({"sensor_start": start}))
                poses = compare_peers.limber_poses(pathlib.Path(folder), 100 * 10**9)
                self.assertEqual((poses[0], len(poses)), ("t_ns,px [m]", 1 + left))
                self.assertEqual(poses[1], f"{102_500_000_000 - 500_000_000 * (left - 1)},0")

    def test_a_cell_says_range_completeness_and_failures(self):
        def runs(*errors, poses=80):
            return [{"ate": ate, "poses": poses, "frames": 100} for ate in errors]
        self.assertEqual(peers_table.accuracy_cell(runs(0.0123, 0.0123)), "0.0123 · 80 %")
        self.assertEqual(peers_table.accuracy_cell(runs(0.5, 1.0, 2.0)), "1 (0.5–2) · 80 %")
        self.assertEqual(peers_table.accuracy_cell(runs(0.5, None)), "0.5 · 80 % · 1 of 2 without")
        self.assertEqual(peers_table.accuracy_cell(runs(None, poses=0)), "none · 0 %")

    def test_tables_have_a_row_a_system_and_a_column_a_profile_for_each_recording(self):
        def one(bend, system, ate, **more):
            return {"bend": bend, "system": system, "start": "own", "ate": ate, "poses": 10, "frames": 10, "cpu_s": 0.3,
                    "peak_mb": 99.6, "source": "flight", "trajectory": "a", **more}
        text = peers_table.tables([one("", "openvins", 0.1, decode_ms=5, estimate_ms=7.25), one("", "ekf", 0.2),
                                   one("ay=1", "ekf", 0.3), one("", "ekf", 0.4, source="drive")])
        self.assertEqual(text.splitlines()[:15], [
            "flight", "", "| system, start | nothing | ay=1 |", "| --- | --- | --- |", "| openvins, own | 0.1 · 100 % |  |",
            "| ekf, own | 0.2 · 100 % | 0.3 · 100 % |", "", "| system, start | repetitions | equal to the bit | ATE, largest / smallest |",
            "| --- | --- | --- | --- |", "", "| system, start | CPU of the process [s] | a frame, with decoding [ms] | without [ms] "
            "| peak memory [MB] |", "| --- | --- | --- | --- | --- |", "| openvins, own | 0.30 | 30.0 | 7.2 | 100 |",
            "| ekf, own | 0.30 | 30.0 | ≤ 25.0 | 100 |", ""])
        self.assertEqual(text.splitlines()[15:21], [
            "| system, start | tracking, p50 [ms] | p99 | filter, p50 [ms] | p99 |", "| --- | --- | --- | --- | --- |", "",
            "drive", "", "| system, start | nothing |"])

    def test_repetitions_are_compared_within_a_profile(self):
        def one(bend, system, trajectory, ate):
            return {"bend": bend, "system": system, "start": "own", "trajectory": trajectory, "ate": ate}
        runs = [one("", "ekf", "a", 0.1), one("", "ekf", "a", 0.1), one("ay=1", "ekf", "b", 0.2), one("ay=1", "ekf", "b", 0.2),
                one("", "libviso2", "c", 0.1), one("", "libviso2", "d", 0.25), one("", "libviso2", "e", None), one("", "lcekf", "f", 1)]
        text = peers_table.repetition_table(runs, [("ekf", "own"), ("libviso2", "own"), ("lcekf", "own")])
        self.assertEqual(text.splitlines()[2:], ["| ekf, own | 2 | 2 of 2 | 1 |", "| libviso2, own | 3 | 0 of 1 | 2.5 |"])

    def test_openvins_time_is_split_into_tracking_and_filter_without_its_display(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            self.assertIsNone(openvins.split(folder))
            write(folder, openvins.TIMES, "# stamp,tracking,...,total\n1,0.006,0.001,0.002,0.009\n2,0.005,0,0.001,0.006\n3,0.007,0,0.003,0.020\n")
            split = openvins.split(folder)
        self.assertEqual({stage: {q: round(ms, 9) for q, ms in found.items()} for stage, found in split.items()},
                         {"track_ms": {"p50": 6.0, "p99": 7.0}, "filter_ms": {"p50": 1.0, "p99": 10.0}})

    def test_limber_time_is_split_alike_and_a_run_that_did_not_end_has_none(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            self.assertIsNone(compare_peers.limber_split(folder))
            write(folder, "summary.json", '{"ms_per_frame": {"p50": 2, "p99": 4, "track": {"p50": 5, "p99": 8}}}')
            split = compare_peers.limber_split(folder)
        self.assertEqual((split["track_ms"]["p99"], split["filter_ms"]["p50"]), (8, 2))

    def test_the_split_is_a_median_over_the_runs_that_have_one(self):
        def one(track, update):
            split = {"track_ms": {"p50": track, "p99": 2 * track}, "filter_ms": {"p50": update, "p99": 3 * update}}
            return {"system": "ekf", "start": "truth", "split": split}
        runs = [one(5, 1), one(6, 2), one(9, 3), {"system": "ekf", "start": "truth", "split": None}, {"system": "libviso2", "start": "none"}]
        self.assertEqual(peers_table.split_table(runs, [("libviso2", "none"), ("ekf", "truth")]).splitlines()[2:], ["| ekf, truth | 6.0 | 12.0 | 2.0 | 6.0 |"])

    def test_frames_of_a_track_log_are_counted_once(self):
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "mav0/tracks0/data.csv", "# t\n7,1,2,3,4,5\n7,2,2,3,,\n9,,,,,\n")
            self.assertEqual(euroc.stereo_stamps(pathlib.Path(folder)), [7, 9])

    def test_matched_points_are_neither_tracked_nor_read_ahead(self):
        with tempfile.TemporaryDirectory() as folder:
            recording = pathlib.Path(folder)
            method = ["--method", "ekf", "--init", "groundtruth"]
            self.assertEqual(compare_peers.limber_options(recording, "ekf", "truth", 90), method + ["--threads", "1", "--max-tracks", "90"])
            write(folder, "mav0/tracks0/data.csv", "# t\n7,1,2,3,4,5\n")
            self.assertEqual(compare_peers.limber_options(recording, "ekf", "truth", None), method)
            self.assertEqual(compare_peers.limber_options(recording, "ekf", "truth", 90), method + ["--max-points", "90"])

    def test_cpu_and_memory_are_those_of_the_child(self):
        with tempfile.TemporaryDirectory() as folder:
            program = "x = bytearray(150 * 2**20)\nwhile __import__('time').process_time() < 0.2: pass\nraise SystemExit(3)"
            code, cpu_s, peak_mb = compare_peers.measured([sys.executable, "-c", program], pathlib.Path(folder) / "log")
        self.assertEqual(code, 3)
        self.assertGreater(cpu_s, 0.19)
        self.assertGreater(peak_mb, 150)


class Libviso2(unittest.TestCase):
    def test_a_rig_with_lenses_is_rectified_by_its_own_calibration(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, shift in (("cam0", "0.1"), ("cam1", "0.35")):
                write(folder, f"mav0/{name}/sensor.yaml", SENSOR.replace("0.0, -1.0, 0.0, 0.1,", f"0.0, -1.0, 0.0, {shift},"))
            text = libviso2.rig(recordings.cameras(pathlib.Path(folder)))
        self.assertIn("rectified: 0\nK0: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [458.5, 0.0, 367.0, 0.0, 457.0", text)
        self.assertIn("distortion1: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [-0.28, 0.07, 0.0002, 1.7e-05]", text)
        self.assertIn("   data: [0.0, -1.0, 0.0, 0.1, 1.0", text.partition("T_body_cam0")[2])
        shift = [float(x) for x in text.partition("T_cam1_cam0")[2].partition("[")[2].partition("]")[0].split(",")]
        self.assertEqual([round(x, 12) for x in shift[3::4]], [0.0, 0.25, 0.0, 1.0])  # x of the body is -y of the camera

    def test_images_of_a_rectified_rig_stay_as_they_are(self):
        camera = {"intrinsics": [300.0, 300.0, 240.0, 320.0], "distortion_coefficients": []}
        other = {"intrinsics": [300.0, 301.0, 240.0, 320.0], "distortion_coefficients": []}
        lens = {"intrinsics": [300.0, 300.0, 240.0, 320.0], "distortion_coefficients": [0.1, 0.0]}
        aside, up = ([[1, 0, 0, -2.0], [0, 1, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]] for y in (0.0, 0.01))
        self.assertTrue(libviso2.is_rectified([camera, camera], aside))
        for cameras, T in (([camera, camera], up), ([camera, other], aside), ([other, other], aside), ([camera, lens], aside)):
            self.assertFalse(libviso2.is_rectified(cameras, T))

    def test_a_lens_the_rectifier_lacks_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("cam0", "cam1"):
                write(folder, f"mav0/{name}/sensor.yaml", SENSOR.replace("radial-tangential", "equidistant"))
            with self.assertRaisesRegex(euroc.Malformed, "cam0: .*equidistant"):
                libviso2.rig(recordings.cameras(pathlib.Path(folder)))

    def test_pairs_are_listed_with_their_images(self):
        with tempfile.TemporaryDirectory() as folder:
            recording = turning_recording(folder, [0] * 3, [0] * 3)
            for name in ("cam0", "cam1"):
                write(folder, f"mav0/{name}/sensor.yaml", SENSOR)
            _, pairs = libviso2.write_inputs(recording, recording / "run")
            rows = pairs.read_text().splitlines()
        self.assertEqual(len(rows), 7)
        self.assertEqual(rows[1], f"1000000000156000000\t{recording}/mav0/cam0/data/3.png\t{recording}/mav0/cam1/data/3.png")

    def test_it_needs_no_start_and_runs_once(self):
        self.assertEqual(compare_peers.columns(["libviso2", "ekf"], ["truth", "own"]),
                         [("libviso2", "none"), ("ekf", "truth"), ("ekf", "own")])


class Kitti(unittest.TestCase):
    def recording(self, folder, times="0.0\n1.045055e-01\n2.1e-01\n"):
        write(folder, "calib.txt", "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP1: 700 0 600 -350 0 700 180 0 0 0 1 0\n")
        write(folder, "times.txt", times)
        for image in ("image_0/000000.png", "image_0/000001.png", "image_0/000002.png", "image_1/000000.png", "image_1/000002.png"):
            write(folder, image, "")
        return pathlib.Path(folder)

    def test_pairs_have_the_times_of_their_numbers(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(recordings.stereo_stamps(self.recording(folder)), [0, 210_000_000])

    def test_a_frame_without_a_time_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(euroc.Malformed, "000002.png, found 1"):
                kitti.stereo_pairs(self.recording(folder, "0.0\n"))

    def test_the_baseline_is_that_of_calib_txt_and_images_are_rectified(self):
        with tempfile.TemporaryDirectory() as folder:
            cameras = recordings.cameras(self.recording(folder))
        self.assertEqual(cameras[1]["T_imu_cam"][0], [1.0, 0.0, 0.0, 0.5])
        self.assertEqual(cameras[0]["intrinsics"], [700.0, 700.0, 600.0, 180.0])
        self.assertIn("rectified: 1\n", libviso2.rig(cameras))

    def test_a_calibration_without_a_camera_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "calib.txt", "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP1: 1 2\n")
            with self.assertRaisesRegex(euroc.Malformed, "P1: and 12"):
                kitti.camera(pathlib.Path(folder), "cam1")


class Choice(unittest.TestCase):
    PROGRAM = pathlib.Path(compare_peers.__file__)

    def refused(self, recording, *options):
        done = subprocess.run([sys.executable, self.PROGRAM, recording, "--limber", sys.executable, "--out", recording / "out", *options],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertFalse((recording / "out").exists())
        return done.stderr

    def test_a_peer_without_its_program_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertIn("libviso2 needs --libviso2", self.refused(pathlib.Path(folder), "--systems", "libviso2,ekf"))
            self.assertIn("openvins needs --runner", self.refused(pathlib.Path(folder), "--systems", "openvins", "--openvins", folder))

    def test_openvins_without_an_imu_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            said = self.refused(pathlib.Path(folder), "--systems", "openvins", "--openvins", folder, "--runner", sys.executable)
        self.assertIn("openvins needs an IMU", said)


class Picture(unittest.TestCase):
    def test_a_panel_is_a_recording_and_a_start_and_what_needs_none_is_in_each(self):
        results = [{"source": source, "start": start} for source, start in
                   (("a", "none"), ("a", "truth"), ("a", "own"), ("b", "none"), ("a", "truth"))]
        self.assertEqual(draw_peers.panels(results), [("a", "truth"), ("a", "own"), ("b", "none")])
        without = [{"bend": "", "system": "libviso2", "start": "none", "ate": 0.5}]
        self.assertEqual(draw_peers.medians(without, "libviso2", "own", lambda r: r["ate"]), {"": 0.5})

    def test_constant_angles_come_first_and_in_order_then_rigs_that_move(self):
        places = draw_peers.places(["", "ay=2", "ay=0.5,shape=vibration,frequency=1", "ay=0.3", "ay=2,shape=ramp,end=8"])
        self.assertEqual([(profile, text) for profile, _, text in places],
                         [("", "0"), ("ay=0.3", "0.3"), ("ay=2", "2"), ("ay=0.5,shape=vibration,frequency=1", "±0.5°\n1 Hz"),
                          ("ay=2,shape=ramp,end=8", "0→2°\nin 8 s")])
        self.assertEqual([x for _, x, _ in places], [0.0, 0.3, 2.0, 3.0, 3.8])
        self.assertEqual([x for _, x, _ in draw_peers.places(["", "ay=-3"])], [-3.0, 0.0])

    def test_an_error_of_kilometres_is_drawn_at_the_edge(self):
        self.assertEqual([draw_peers.drawn_error({"ate": ate}) for ate in (None, 0.5, 3000.0)], [None, 0.5, draw_peers.LOST_M])

    def test_a_point_is_the_median_of_what_there_is(self):
        results = [{"bend": "ay=1", "system": "ekf", "start": "own", "ate": ate} for ate in (0.1, None, 0.3, 0.2)]
        results.append({"bend": "", "system": "ekf", "start": "own", "ate": None})
        self.assertEqual(draw_peers.medians(results, "ekf", "own", lambda r: r["ate"]), {"ay=1": 0.2})


class Simulator(unittest.TestCase):
    EVALUATION = {"ate_m": {"se3": 0.1}, "ape": {"none": {"translation_m": {"rmse": 9}}, "first_pose": {"translation_m": {"rmse": 3}}},
                  "anees": {"none": {"pose": 8, "position": 7}, "first_pose": {"pose": 2, "position": 1}}}

    def test_a_start_from_the_truth_is_judged_unaligned_another_from_its_first_pose(self):
        for start, expected in (("truth", (0.1, 9, 8, 7)), ("groundtruth", (0.1, 9, 8, 7)), ("auto", (0.1, 3, 2, 1))):
            self.assertEqual(tuple(compare_simulator.scores(self.EVALUATION, start).values()), expected)
        self.assertEqual(set(compare_simulator.scores(None, "auto").values()), {None})

    def test_a_cell_has_median_range_and_failures(self):
        self.assertEqual(compare_simulator.spread([0.04]), "0.04")
        self.assertEqual(compare_simulator.spread([0.3, 0.1, 0.2]), "0.2 (0.1–0.3)")
        self.assertEqual(compare_simulator.spread([0.1, None]), "0.1, 1 without")
        self.assertEqual(compare_simulator.spread([None]), "–")

    def test_the_table_has_a_row_a_bend(self):
        results = [{"bend": bend, "system": "lcekf", "start": "auto", "ate": ate, "anees": 1.5}
                   for bend, ate in (("exact", 0.1), ("exact", 0.3), ("wave", 0.2))]
        self.assertEqual(compare_simulator.table(results, "ate", "anees").splitlines()[2:],
                         ["| exact | 0.2 (0.1–0.3) · 1.5 (1.5–1.5) |", "| wave | 0.2 · 1.5 |"])


if __name__ == "__main__":
    unittest.main()
