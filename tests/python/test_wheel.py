# SPDX-License-Identifier: MIT
import os
import pathlib
import shutil
import subprocess
import sys
import zipfile

import pytest

SOURCE = pathlib.Path(os.environ["LIMBER_SOURCE_DIR"])


def test_a_wheel_stands_on_its_own(tmp_path):
    pytest.importorskip("build", reason="Debian: python3-build")
    project = tmp_path / "project"
    project.mkdir()
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "CMakeLists.txt"):
        shutil.copy(SOURCE / name, project)
    environment = {**os.environ, "LIMBER_BUILD_DIR": os.environ["LIMBER_BINARY_DIR"], "PYTHONPATH": ""}
    subprocess.run([sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path, project],
                   env=environment, check=True, capture_output=True, text=True)
    wheel, = tmp_path.glob("limber-*.whl")
    assert "any" not in wheel.name
    names = zipfile.ZipFile(wheel).namelist()
    assert {"limber/__init__.py", "limber/_limber.pyi", "limber/py.typed", "limber/scenarios/paper_iv.yaml"} <= set(names)

    subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--target",
                    tmp_path / "site", wheel], check=True, capture_output=True)
    code = "import limber; print(limber.__file__, len(limber.simulate('drone_none').frames))"
    said = subprocess.run([sys.executable, "-c", code], env={**environment, "PYTHONPATH": str(tmp_path / "site")},
                          cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert said.split() == [str(tmp_path / "site" / "limber" / "__init__.py"), "601"]
