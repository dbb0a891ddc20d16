# SPDX-License-Identifier: MIT
import pytest

import limber


def short(name, duration=5.0, seed=1, **options):
    scenario = limber.Scenario.parse(limber.Scenario(limber._SCENARIOS / f"{name}.yaml").text)
    scenario.duration = duration
    return limber.simulate(scenario, seed, **options)


@pytest.fixture(scope="session")
def recording():
    return short("drone_constant")


@pytest.fixture(scope="session")
def run(recording):
    return limber.run(recording)
