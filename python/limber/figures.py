# SPDX-License-Identifier: MIT
"""Figures of a run with matplotlib: each function draws into `axes` or new ones, and returns them."""
import numpy as np

_AXES = ("x", "y", "z")


def _pyplot():
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("limber.figures needs matplotlib (Debian: python3-matplotlib)") from error
    return pyplot


def _rows(axes, count):
    if axes is None:
        axes = _pyplot().subplots(count, 1, sharex=True, figsize=(8, 2 * count), layout="constrained")[1]
    axes = np.atleast_1d(axes)
    if len(axes) != count:
        raise ValueError(f"axes: expected {count}, found {len(axes)}")
    return axes


def _seconds(t_ns, since_ns):
    return (np.asarray(t_ns) - since_ns) * 1e-9


def _with_band(ax, t, value, sigma, label):
    line, = ax.plot(t, value, linewidth=1, label=label)
    ax.fill_between(t, -3 * sigma, 3 * sigma, color=line.get_color(), alpha=0.2, linewidth=0, label="3 sigma")


def rotation_vectors(R):
    """Rotation vectors [rad] of rotation matrices (N, 3, 3), angles below pi."""
    w = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    sine, cosine = np.linalg.norm(w, axis=1), (np.trace(R, axis1=1, axis2=2) - 1) / 2
    angle = np.arctan2(sine, cosine)
    return w * np.divide(angle, sine, out=np.ones_like(sine), where=sine > 1e-12)[:, None]


def errors(run):
    """Times [s], estimate minus truth in position (M, 3) [m] and attitude (M, 3) [rad], and their sigmas (M, 6).

    In the world and alignment of run.truth_p; attitude errors in the body frame, as the covariance has them.
    Raises ValueError without ground truth.
    """
    _, at, of_truth = np.intersect1d(run.t_ns, run.truth_t_ns, return_indices=True)
    if not len(at):
        raise ValueError("the recording of this run has no ground truth")
    turned = np.einsum("nji,njk->nik", run.truth_R[of_truth], run.R[at])
    sigma = np.sqrt(np.einsum("nii->ni", run.covariance[at]))
    return (_seconds(run.t_ns[at], run.t_ns[0]), run.p[at] - run.truth_p[of_truth], rotation_vectors(turned), sigma)


def trajectory(*runs, axes=None):
    """Paths from above: one line a run (or Trajectory), dashed the truth of the first that has one."""
    if axes is None:
        axes = _pyplot().subplots(layout="constrained")[1]
    for run in runs:
        axes.plot(run.p[:, 0], run.p[:, 1], linewidth=1, label=getattr(run, "method", "estimate"))
    truths = [run.truth_p for run in runs if len(getattr(run, "truth_p", ()))]
    if truths:
        axes.plot(truths[0][:, 0], truths[0][:, 1], "k--", linewidth=1, label="truth")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes.legend()
    return axes


def error(run, axes=None):
    """Errors of position and attitude with the filter's own 3 sigma, six axes one above the other."""
    axes = _rows(axes, 6)
    t, position, attitude, sigma = errors(run)
    values = np.hstack([position, np.degrees(attitude)])
    sigma = np.hstack([sigma[:, :3], np.degrees(sigma[:, 3:])])
    for k, ax in enumerate(axes):
        _with_band(ax, t, values[:, k], sigma[:, k], run.method)
        ax.set_ylabel(f"{_AXES[k]} [m]" if k < 3 else f"about {_AXES[k - 3]} [deg]")
    axes[0].legend()
    axes[-1].set_xlabel("time [s]")
    return axes


def calibration(run, axes=None):
    """What the run says of its calibration, true minus assumed with 3 sigma.

    Of the parameters that were estimated, else of the six of the rig as the health monitor gathered them.
    """
    if run.calibration is not None:
        names, t_ns = run.calibration["names"], run.calibration["t_ns"]
        value, sigma = run.calibration["error"], run.calibration["sigma"]
    else:
        reports = [frame.health for frame in run.frames if frame.health is not None]
        if not reports:
            raise ValueError(f"{run.method} neither estimates nor watches the calibration")
        names, t_ns = ("ax", "ay", "az", "tx", "ty", "tz"), [report.t_ns for report in reports]
        value = np.array([report.gathered_delta for report in reports])
        sigma = np.array([report.gathered_sigma for report in reports])
    axes = _rows(axes, len(names))
    t = _seconds(t_ns, run.t_ns[0])
    for ax, name, v, s in zip(axes, names, value.T, sigma.T):
        known = np.isfinite(s)
        line, = ax.plot(t[known], v[known], linewidth=1)
        ax.fill_between(t[known], (v - 3 * s)[known], (v + 3 * s)[known], color=line.get_color(), alpha=0.2, linewidth=0)
        ax.axhline(0, color="k", linewidth=0.5)
        ax.set_ylabel(name)
    axes[-1].set_xlabel("time [s]")
    return axes
