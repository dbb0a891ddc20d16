# SPDX-License-Identifier: MIT
import os
import pathlib
import subprocess

import numpy as np
import pytest

import limber
from conftest import short

PROGRAM = os.environ["LIMBER_PROGRAM"]
BAGS = pathlib.Path(os.environ["LIMBER_SOURCE_DIR"]) / "tests/bags/fixtures"


@pytest.fixture(scope="module")
def bent():
    recording = short("drone_none", 8.0)
    recording.assume_error("0,1,0,10%,0,0")
    return recording


@pytest.fixture(scope="module")
def mended(bent):
    return limber.recalibrate(bent)


def test_a_bent_rig_is_mended(bent, mended):
    assert mended.verdict == "better" and mended["axes"]["ay"]["seen"]
    before = bent.calibration.theta.copy()
    given = limber.run(bent, "ekf").summary["ate_m"]["se3"]
    bent.calibration = mended.calibration
    try:
        assert limber.run(bent, "ekf").summary["ate_m"]["se3"] < given
    finally:
        calibration = bent.calibration
        calibration.theta = before
        bent.calibration = calibration


def test_what_is_found_is_what_the_program_finds(bent, mended, tmp_path):
    bent.write(tmp_path / "log")
    done = subprocess.run([PROGRAM, "recalibrate", tmp_path / "log", "--out", tmp_path / "program"], check=False,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    mended.write(tmp_path / "module")
    ours, theirs = (limber.read(tmp_path / "log", calib=tmp_path / writer / "camchain.yaml").calibration.theta
                    for writer in ("module", "program"))
    # Not bit by bit: in the module Ceres keeps to Eigen's functions as it was compiled with them.
    assert np.allclose(ours, theirs, rtol=0, atol=1e-6)
    assert np.allclose(ours, mended.calibration.theta, rtol=0, atol=1e-12)
    with pytest.raises(RuntimeError, match="camchain.yaml"):
        (tmp_path / "mine").mkdir()
        (tmp_path / "mine/camchain.yaml").write_text("somebody's\n")
        mended.write(tmp_path / "mine")
    assert (tmp_path / "mine/camchain.yaml").read_text() == "somebody's\n"


def test_a_bag_is_read_with_its_calibration():
    recording = limber.read(BAGS / "ros1_lz4.bag", calib=BAGS / "camchain.yaml", imu=BAGS / "imu.yaml")
    assert len(recording) > 0 and len(recording.imu) > 0
    with pytest.raises(ValueError, match="calib"):
        limber.read(BAGS / "ros1_lz4.bag")
    with pytest.raises(ValueError, match="topics"):
        limber.read(BAGS.parent / "nowhere", topics="left=/cam0")
