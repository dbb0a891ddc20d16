# SPDX-License-Identifier: MIT
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import limber
from conftest import short, short_scenario

PROGRAM = os.environ["LIMBER_PROGRAM"]


def files_of(folder):
    """Content of the files, and of the summary, but for what tells times of the machine and its paths."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()
             if path.name not in ("summary.json", "report.html", "frames.csv")}
    summary = json.loads((folder / "summary.json").read_text())
    for key in ("ms_per_frame", "start_ms", "realtime_factor", "peak_rss_mb"):
        del summary[key]
    return files | {"summary": summary}


@pytest.mark.parametrize("method", ["lcekf", "adaptive"])
def test_a_run_is_that_of_the_program_bit_by_bit(recording, tmp_path, method):
    recording.write(tmp_path / "log")
    subprocess.run([PROGRAM, "run", tmp_path / "log", "--method", method, "--out", tmp_path / "program"], check=True,
                   capture_output=True)
    limber.run(tmp_path / "log", method).write(tmp_path / "module")
    ours, theirs = files_of(tmp_path / "module"), files_of(tmp_path / "program")
    assert "trajectory.tum" in ours and ours == theirs


def test_mistakes_in_the_first_frames_are_said(recording, tmp_path):
    recording.write(tmp_path / "log")
    samples = tmp_path / "log" / "mav0" / "imu0" / "data.csv"
    head, *rows = samples.read_text().splitlines()
    in_g = [",".join(cells[:4] + [repr(float(a) / 9.81) for a in cells[4:]]) for cells in (row.split(",") for row in rows)]
    samples.write_text("\n".join([head, *in_g]) + "\n")
    run = limber.run(tmp_path / "log")
    assert any("looks like a mistake: the accelerometer is in g" in note for note in run.notes)
    assert "the accelerometer is in g" in json.dumps(run.summary["answer"], ensure_ascii=False)


def test_a_simulation_is_that_of_the_program(recording, tmp_path):
    (tmp_path / "short.yaml").write_text(short_scenario("drone_constant", 6.0).text)
    subprocess.run([PROGRAM, "simulate", tmp_path / "short.yaml", "--seed", "1", "--out", tmp_path / "log"], check=True,
                   capture_output=True)
    assert np.array_equal(limber.read(tmp_path / "log").imu, recording.imu)


def test_a_run_hands_out_views_of_sound_shape(run):
    n = len(run.t_ns)
    assert n == len(run.recording) == len(run.frames)
    for array, shape in ((run.p, (n, 3)), (run.R, (n, 3, 3)), (run.v, (n, 3)), (run.covariance, (n, 6, 6))):
        assert array.shape == shape and not array.flags.owndata and not array.flags.writeable
    assert np.array_equal(run.covariance, run.covariance.transpose(0, 2, 1))
    assert run.frames[-1].t_ns == run.t_ns[-1] and run.frames[-1].health is not None
    assert run.summary["method"] == run.method == "lcekf"
    with pytest.raises(IndexError):
        run.frames[n]


def test_observers_see_every_frame_and_may_stop(recording):
    seen = []
    run = limber.run(recording, observe=lambda report: seen.append(report.t_ns))
    assert seen == run.t_ns[-len(seen):].tolist() and len(seen) > 50

    def stop(report):
        raise StopAsyncIteration("enough")

    with pytest.raises(StopAsyncIteration, match="enough"):
        limber.run(recording, observe=stop)


def test_ctrl_c_ends_a_run():
    # What a shell starts in the background inherits that Ctrl-C is ignored.
    code = ("import limber, signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "recording = limber.simulate('drone_none')\n"
            "print('go', flush=True)\nwhile True: limber.run(recording)\n")
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "go\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    finally:
        process.kill()
    assert "KeyboardInterrupt" in errors and process.returncode != 0


def test_the_gil_is_released_while_a_run_computes(recording):
    import threading
    worker = threading.Thread(target=limber.run, args=(recording,))
    worker.start()
    turns = 0
    while worker.is_alive():
        time.sleep(0.001)
        turns += 1
    assert turns > 20  # one, if it were held


def test_strangers_files_stay(run, tmp_path):
    (tmp_path / "trajectory.tum").write_text("mine")
    with pytest.raises(limber.DataError, match="limber did not write"):
        run.write(tmp_path)
    assert (tmp_path / "trajectory.tum").read_text() == "mine"
    run.write(tmp_path, force=True)
    trajectory = limber.read_trajectory(tmp_path / "trajectory.tum")
    assert trajectory.t_ns.tolist() == run.t_ns.tolist()
    with pytest.raises(limber.DataError, match="those of an earlier run"):
        run.write(tmp_path)
    with pytest.raises(limber.DataError, match="no file of this name"):
        trajectory.write_tum(tmp_path / "truth.tum")
    trajectory.write_tum(tmp_path / "truth.tum", force=True)


def test_unknown_options_are_refused(recording):
    with pytest.raises(TypeError):
        limber.run(recording, sigma=1.0)
    with pytest.raises(ValueError, match="lcekf alone has constraints"):
        limber.run(recording, "ekf", constraints="full")


@pytest.fixture(scope="module")
def sound():
    return limber.health(short("drone_none", 10.0))


def test_what_moved_since_an_earlier_recording_is_said(sound, tmp_path):
    (tmp_path / "health_state.json").write_text(sound.state)
    assert sound.verdict == "ok" and sound["since"] is None
    same = limber.health(short("drone_none", 10.0), since=sound)
    assert same["since"]["verdict"] == "ok" and "nothing moved that matters" in str(same)
    moved = limber.health(short("drone_constant", 10.0), since=tmp_path)
    assert moved["since"]["verdict"] == "degraded"
    assert moved.verdict == "degraded" and moved["health"]["present"]["most_likely_axis"]
    assert "explains it best" in str(moved)


def test_what_moved_is_not_asked_of_another_rig(sound):
    with pytest.raises(limber.DataError, match="the cameras of this recording"):
        limber.health(short("paper_i", 2.0), since=sound)


def test_evaluate_agrees_with_numpy(run, recording):
    result = limber.evaluate(run, recording)
    truth = np.stack([np.interp(run.t_ns, recording.truth_t_ns, recording.truth_p[:, k]) for k in range(3)], axis=1)
    rmse = np.sqrt(np.mean(np.sum((run.p - truth)**2, axis=1)))
    assert result["ate_m"]["none"] == pytest.approx(rmse, rel=1e-6)
    assert result["anees"] is not None
    assert limber.evaluate(limber.Trajectory(run.t_ns, run.p, run.R), recording)["ate_m"] == result["ate_m"]


def test_names_need_not_be_utf8(run, recording, tmp_path):
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    run.write(folder)
    result = limber.evaluate(folder, recording)
    assert result["ate_m"] == limber.evaluate(run, recording)["ate_m"]


def test_runs_compare_as_the_program_compares_them(tmp_path):
    recording = short("drone_constant", 6.0)
    for method in ("ekf", "lcekf"):
        limber.run(recording, method).write(tmp_path / method)
    comparison = limber.compare([tmp_path / "ekf", tmp_path / "lcekf"], piece=0.5)
    assert [run["method"] for run in comparison["runs"]] == ["ekf", "lcekf"]
    assert len(comparison["differences"]) == 1
    assert "cannot tell" in str(comparison) or "better" in str(comparison) or "worse" in str(comparison)
    assert limber.compare(tmp_path, piece=0.5) == comparison
    with pytest.raises(limber.DataError, match="none"):
        limber.compare([tmp_path / "none"])
    with pytest.raises(ValueError, match="found none"):
        limber.compare([])


def test_smoothing_uses_the_whole_recording():
    if not hasattr(limber._limber, "smooth_recording"):
        pytest.skip("built without Ceres")
    recording = short("drone_constant", 3.0)
    smoothed = limber.smooth(recording, "constant", init="groundtruth")
    filtered = limber.run(recording, init="groundtruth")
    assert smoothed.method == "smooth-constant"
    of = [limber.evaluate(run, recording)["ate_m"]["se3"] for run in (smoothed, filtered)]
    assert of[0] < of[1]


def test_smoothing_may_be_causal():
    if not hasattr(limber._limber, "smooth_recording"):
        pytest.skip("built without Ceres")
    options = {"recording": short("drone_constant", 1.0), "theta": "constant", "init": "groundtruth"}
    smoothed, causal = limber.smooth(**options), limber.smooth(**options, causal=True, window=0.2)
    assert causal.method == "smooth-constant-causal" and len(causal.t_ns) == len(smoothed.t_ns)
    assert not np.array_equal(causal.p, smoothed.p)
    with pytest.raises(ValueError, match="window"):
        limber.smooth(**options, causal=True, window=0.0)


def test_a_study_is_a_table(tmp_path):
    scenario = short_scenario("drone_constant", 3.0)  # a start may take half of it, and 1 s tells a drone too little
    study = limber.study(scenario, "ekf,lcekf", runs=2, database=tmp_path / "study.sqlite")
    rows = study.table()
    assert [row["method"] for row in rows] == ["ekf", "lcekf"] and all(row["runs"] == 2 for row in rows)
    t, mean, count = study.curve("drone_constant", "lcekf", "position_squared_error")
    assert len(t) == len(mean) and set(count) == {2}
    of_runs = [run["position_rmse_m"] for run in study.runs("drone_constant", "lcekf")]
    assert rows[1]["position_rmse_m"] == pytest.approx(np.sqrt(np.mean(np.square(of_runs))))
    assert "| lcekf" in str(limber.Study(tmp_path / "study.sqlite"))
