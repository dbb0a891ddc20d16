# SPDX-License-Identifier: MIT
"""Stereo navigation for rigs that bend: the C++ library limber.

    recording = limber.read("DATASET")               # or limber.simulate("paper_iv", seed=1)
    run = limber.run(recording, method="lcekf")       # run.p, run.R, run.covariance: NumPy views
    print(limber.health(recording))                   # is my calibration the problem?

Step by step: StereoTracker, OnlineNavigator (or SensorStart and Navigator). Arrays that a Recording, a Run or a
StereoFrame hands out are read-only views of C++ memory. Times are integers in nanoseconds; docs/python.md says more.
"""
import json as _json
import os as _os
import pathlib as _pathlib

from . import _limber
from ._limber import (PARAMETER_NAMES, BodyFrame, Camera, DataError, DivergenceError, Equidistant, FrameCleaner,
                      FrameReport, HealthReport, ImuNoise, InitialState, Navigator, NavigatorOptions,
                      NoDistortion, OdometryNoise, Omni, OnlineNavigator, OnlineReport, Pose, RadialTangential,
                      Rational, Recording, Refusal, Run, RunOptions, Scenario, SensorStart, StartReport, State,
                      StereoCalibration, StereoFrame, StereoTracker, Study, Trajectory, __version__, frames,
                      pose_from_rig, read_trajectory, rig_from_pose, set_up)

__all__ = [
    "PARAMETER_NAMES", "BodyFrame", "Camera", "Comparison", "DataError", "DivergenceError", "Equidistant",
    "FrameCleaner", "FrameReport", "Health", "HealthReport", "ImuNoise", "InitialState", "Navigator",
    "NavigatorOptions", "NoDistortion", "OdometryNoise", "Omni", "OnlineNavigator", "OnlineReport", "Pose",
    "RadialTangential", "Rational", "Recalibration", "Recording", "Refusal", "Run", "RunOptions", "Scenario", "SensorStart",
    "StartReport", "State", "StereoCalibration", "StereoFrame", "StereoTracker", "Study", "Trajectory",
    "compare", "evaluate", "frames", "health", "pose_from_rig", "read", "read_trajectory", "recalibrate",
    "rig_from_pose", "run", "scenarios", "set_up", "simulate", "smooth", "study"
]

_SCENARIOS = _pathlib.Path(__file__).parent / "scenarios"


def read(path, *, calib="", imu="", images="", topics="", readout_time=None):
    """Reads a recording; its content tells the format (docs/formats-recordings.md).

    calib, imu, images, topics, readout_time: as --calib, --imu, --images, --topics and --readout-time of `limber run`;
    a bag needs calib.
    Raises DataError if a file cannot be used, ValueError if an option is missing or does not fit.
    """
    return _limber.read_recording(path, calib, imu, images, topics, readout_time)


def scenarios():
    """Names of the scenarios that come with limber, for simulate() and study()."""
    return sorted(path.stem for path in _SCENARIOS.glob("*.yaml"))


def _scenario(scenario):
    if isinstance(scenario, Scenario):
        return scenario
    if isinstance(scenario, str) and _os.sep not in scenario and not scenario.endswith((".yaml", ".yml")):
        if scenario not in scenarios():
            raise ValueError(f"scenario: expected a file (.yaml), a Scenario or one of {', '.join(scenarios())}; "
                             f"found '{scenario}'")
        scenario = _SCENARIOS / f"{scenario}.yaml"
    return Scenario(scenario)


def simulate(scenario, seed=0, run=0, *, pixels=None, faults=(), imu=True):
    """Makes a recording of a scenario: a YAML file, a Scenario, or the name of one of scenarios().

    pixels: 'white' or 'realistic' (as on real images), instead of the scenario's
    faults: such as 'imu-gap=5:2' (at 5 s, for 2 s); scenarios/README.md lists them
    imu: False leaves the IMU out
    The same scenario, seed and run give the same bits, and those of `limber simulate`.
    """
    scenario = _scenario(scenario)
    if pixels is not None or faults or not imu:
        scenario = Scenario.parse(scenario.text)
        if pixels is not None:
            scenario.set_pixels(pixels)
        for fault in faults:
            scenario.add_fault(fault)
        scenario.use_imu = scenario.use_imu and imu
    return _limber.simulate_scenario(scenario, seed, run)


def run(recording, method="lcekf", *, observe=None, **options):
    """Navigates through a recording (or the path of one), as `limber run` does.

    observe: called with the FrameReport of every frame once it is processed; what it raises ends the run
    options: those of RunOptions, named as on the command line: constraints, assume_error, estimate, sigma_px, ...
    Raises ValueError if the recording cannot be run like that, DivergenceError if the filter breaks down.
    """
    recording = _recording(recording)
    return _limber.run_recording(recording, RunOptions(recording, method, **options), observe)


def smooth(recording, theta="free", *, causal=False, window=2.0, threads=1, **options):
    """Least squares over the whole recording, as `limber smooth` does: every state from what all frames say.

    theta: what the rig does: trusted, constant, piecewise:SECONDS, walk, or free in every frame
    causal: every state from the frames up to it alone, one problem a frame
    window: with causal, how long before a frame all is solved anew with it [s]
    options: those of RunOptions
    """
    if not hasattr(_limber, "smooth_recording"):
        raise RuntimeError("this build has no smoother: it was made without Ceres (LIMBER_BUILD_SMOOTH)")
    recording = _recording(recording)
    return _limber.smooth_recording(recording, RunOptions(recording, **options), theta,
                                    window if causal else None, threads)


class Health(dict):
    """What `limber health --json` says, as a dictionary; str() is the text for people."""

    def __init__(self, json, text, state):
        super().__init__(_json.loads(json))
        self._text = text
        self.state = state  #: the text of health_state.json, for `since`; empty if nothing could be judged

    @property
    def verdict(self):
        """'ok', 'degraded', 'decalibrated' or 'cannot tell'."""
        return self["verdict"]

    def __str__(self):
        return self._text


def health(recording, *, since=None, **options):
    """Is the calibration the problem? What moved, and since when; as `limber health` does.

    since: what moved since an earlier recording: its Health, or the folder or health_state.json of `limber health`
    options: those of RunOptions, for instance false_alarms (per hour) or assume_error
    """
    recording = _recording(recording)
    return Health(*_limber.diagnose_recording(recording, RunOptions(recording, "lcekf", **options),
                                              _state_of(since)))


def _state_of(since):
    """The text of a health_state.json; empty of nothing."""
    if since is None or isinstance(since, Health):
        return since.state if since else ""
    path = _pathlib.Path(since)
    return (path / "health_state.json" if path.is_dir() else path).read_text(encoding="utf-8")


class Recalibration(dict):
    """What `limber recalibrate` says (recalibration.json) as a dictionary; str() is the text for people."""

    def __init__(self, found):
        super().__init__(_json.loads(found.json))
        self._found = found

    @property
    def verdict(self):
        """'better', 'within tolerance', 'not better' or 'cannot tell'."""
        return self["recalibration"]

    @property
    def calibration(self):
        """The corrected calibration, whatever the verdict; to be put into recording.calibration."""
        return self._found.calibration

    def write(self, folder, *, force=False):
        """Writes recalibration.json and the corrected calibration in all formats, whatever the verdict.

        force: replace earlier results, and other files of their names
        """
        self._found.write(folder, force)

    def __str__(self):
        return self._found.text


def recalibrate(recording, **options):
    """A corrected calibration, and whether it is a better one where it was not made; as `limber recalibrate` does.

    options: those of RunOptions, for instance assume_error or sigma_px
    """
    if not hasattr(_limber, "recalibrate_recording"):
        raise RuntimeError("this build cannot recalibrate: it was made without Ceres (LIMBER_BUILD_SMOOTH)")
    recording = _recording(recording)
    return Recalibration(_limber.recalibrate_recording(recording, RunOptions(recording, **options)))


def evaluate(estimate, truth, *, max_time_difference=0.01, rpe_distance=100.0):
    """Compares two trajectories as `limber evaluate --json` does: ATE, RPE, attitude, NEES; a dictionary.

    Each is a Run, a Trajectory, a Recording (its ground truth), or the path of a file, a run or a recording.
    """
    return _json.loads(
        _limber.evaluate_json(_trajectory(estimate), _trajectory(truth), max_time_difference, rpe_distance))


class Comparison(dict):
    """What `limber compare --json` says, as a dictionary; str() is the tables for people."""

    def __init__(self, json, text):
        super().__init__(_json.loads(json))
        self._text = text

    def __str__(self):
        return self._text


def compare(runs, *, piece=None, across_assumptions=False):
    """Runs beside each other as `limber compare` has them: errors, and differences with intervals.

    runs: folders that Run.write or `limber run --out` wrote, or folders of such folders
    piece: length of the pieces that relative errors are of [m]; None: ten or more fit into the path
    across_assumptions: pair runs that assume different things of their recording, too
    """
    paths = [runs] if isinstance(runs, (str, _os.PathLike)) else list(runs)
    if not paths:
        raise ValueError("runs: expected a folder at least, found none")
    return Comparison(*_limber.compare_folders(paths, piece, across_assumptions))


def study(scenario, methods="ekf,ekf-full,lcekf", *, runs=100, seed=1, init="auto", database, threads=0):
    """Monte Carlo as `limber study` does it: computes what is missing, keeps it in a database (SQLite).

    scenario: what simulate() takes, or a list of that
    methods: with options such as 'lcekf:rotation', separated by commas
    init: 'auto', from the sensors, or 'groundtruth', from the truth plus a drawn error
    Returns a Study; print it for the table. Ctrl-C keeps what is done, and the same call goes on.
    """
    several = scenario if isinstance(scenario, (list, tuple)) else [scenario]
    return _limber.run_study([_scenario(one) for one in several], methods, runs, seed, init, database, threads)


def _recording(recording):
    return recording if isinstance(recording, Recording) else read(recording)


def _trajectory(source):
    if isinstance(source, Run):
        return Trajectory(source.t_ns, source.p, source.R, source.covariance, name=source.method)
    if isinstance(source, Recording):
        return Trajectory(source.truth_t_ns, source.truth_p, source.truth_R, name=source.name)
    return source if isinstance(source, Trajectory) else read_trajectory(source)


Run.summary = property(lambda self: _json.loads(self.summary_json),
                       doc="Figures of merit, what summary.json holds: docs/formats-results.md.")
