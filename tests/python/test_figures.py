# SPDX-License-Identifier: MIT
import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

import limber
from limber import figures


def test_errors_and_their_sigmas_agree_with_the_summary(run):
    _, position, attitude, sigma = figures.errors(run)
    assert np.sqrt(np.mean(np.sum(position**2, axis=1))) == pytest.approx(run.summary["position_rmse_m"])
    degrees = np.degrees(np.linalg.norm(attitude, axis=1))
    assert np.sqrt(np.mean(degrees**2)) == pytest.approx(run.summary["attitude_rmse_deg"], rel=1e-6)
    assert sigma.shape == (len(position), 6) and (sigma >= 0).all()


def test_figures_draw_what_they_are_given(run, recording):
    full = limber.run(recording, "ekf-full")
    path = figures.trajectory(run, full)
    assert [line.get_label() for line in path.lines] == ["lcekf", "ekf-full", "truth"]
    assert np.array_equal(path.lines[0].get_xdata(), run.p[:, 0])
    assert len(figures.error(run)) == 6
    watched, estimated = figures.calibration(run), figures.calibration(full)
    assert [ax.get_ylabel() for ax in watched] == [ax.get_ylabel() for ax in estimated] == list(
        limber.PARAMETER_NAMES[:6])
    assert estimated[0].lines[0].get_ydata()[-1] == full.calibration["error"][-1, 0]
