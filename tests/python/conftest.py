# SPDX-License-Identifier: MIT
import re

import pytest

import limber


def pytest_configure(config):
    config.addinivalue_line("markers", "full: many of what another test has a few of; `scripts/test.sh --full`")


def short_scenario(name, duration):
    """One of limber's, cut short, with half of its points: what a run costs goes with their square."""
    text = limber.Scenario(limber._SCENARIOS / f"{name}.yaml").text
    points = re.compile(r"(?m)^(  points: )(\d+)$")
    assert points.search(text)
    scenario = limber.Scenario.parse(points.sub(lambda found: f"{found[1]}{int(found[2]) // 2}", text))
    scenario.duration = duration
    return scenario


def short(name, duration=6.0, seed=1, **options):
    return limber.simulate(short_scenario(name, duration), seed, **options)


@pytest.fixture(scope="session")
def recording():
    return short("drone_constant")


@pytest.fixture(scope="session")
def run(recording):
    return limber.run(recording)
