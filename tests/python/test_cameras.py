# SPDX-License-Identifier: MIT
"""Lenses against OpenCV's own, where Python has it."""
import numpy as np
import pytest

import limber

WIDTH, HEIGHT, F, C = 752, 480, (460.0, 457.0), (367.0, 248.0)
RATIONAL = dict(k1=0.4579, k2=-2.5553, p1=0.00098, p2=-0.0002, k3=1.4896, k4=0.338, k5=-2.3753, k6=1.4155)
OMNI = dict(xi=0.8, k1=-0.335, k2=0.132, p1=0.00056, p2=0.00058)


def camera(lens):
    return limber.Camera(*F, *C, WIDTH, HEIGHT, lens)


def rays(of):
    """Of a grid over the image, three metres long."""
    pixels = [(u, v) for u in np.arange(0.5, WIDTH, 41.0) for v in np.arange(0.5, HEIGHT, 29.0)]
    return 3.0 * np.array([of.unproject(uv) for uv in pixels]), np.array(pixels)


@pytest.mark.parametrize("lens", [limber.Rational(k3=-0.05), limber.Rational(**RATIONAL), limber.Omni(**OMNI)])
def test_project_undoes_unproject(lens):
    of = camera(lens)
    X, pixels = rays(of)
    assert np.abs(np.array([of.project(x) for x in X]) - pixels).max() < 1e-9


def test_coefficients_are_attributes():
    for make, values in ((limber.Rational, RATIONAL), (limber.Omni, OMNI)):
        lens = make(**values)
        assert {name: getattr(lens, name) for name in values} == values
        lens.k1 = 0.5
        of = camera(lens)
        assert type(of.distortion) is make and of.distortion.k1 == 0.5


def test_a_rational_lens_is_opencv_s():
    cv2 = pytest.importorskip("cv2")
    of = camera(limber.Rational(**RATIONAL))
    X, pixels = rays(of)
    order = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    found, _ = cv2.projectPoints(X, np.zeros(3), np.zeros(3), matrix(F), np.array([RATIONAL[k] for k in order]))
    assert np.abs(found[:, 0] - pixels).max() < 1e-9


def test_an_omni_lens_is_opencv_s():
    omnidir = getattr(pytest.importorskip("cv2"), "omnidir", None)
    if omnidir is None:
        pytest.skip("an OpenCV without its contributed modules")
    of = camera(limber.Omni(**OMNI))
    X, pixels = rays(of)
    K = matrix([(1.0 + OMNI["xi"]) * f for f in F])
    D = np.array([[OMNI[k] for k in ("k1", "k2", "p1", "p2")]])
    found, _ = omnidir.projectPoints(X[:, None], np.zeros(3), np.zeros(3), K, OMNI["xi"], D)
    assert np.abs(found.reshape(-1, 2) - pixels).max() < 1e-9


def matrix(f):
    return np.array([[f[0], 0.0, C[0]], [0.0, f[1], C[1]], [0.0, 0.0, 1.0]])
