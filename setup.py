# SPDX-License-Identifier: MIT
"""Builds the Python module with CMake.

LIMBER_BUILD_DIR names a build tree to use (its module is brought up to date), else one is made; LIMBER_ARCH is the
processor to compile for, as CMake's option of that name.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Distribution, setup
from setuptools.command.build import build

SOURCE = pathlib.Path(__file__).resolve().parent
VERSION = re.search(r"VERSION (\d+\.\d+\.\d+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)


class BinaryDistribution(Distribution):
    """Not for any machine, though setuptools compiles nothing itself."""

    def has_ext_modules(self):
        return True


class CMakeBuild(build):
    """Has CMake put the package together, and takes it as it is."""

    def run(self):
        tree = os.environ.get("LIMBER_BUILD_DIR")
        if tree is None:
            tree = os.path.abspath(os.path.join(self.build_temp, "cmake"))
            subprocess.check_call([
                "cmake", "-S", str(SOURCE), "-B", tree, "-DCMAKE_BUILD_TYPE=Release", "-DLIMBER_BUILD_PYTHON=ON",
                "-DLIMBER_BUILD_TESTS=OFF", "-DLIMBER_BUILD_EXAMPLES=OFF", "-DLIMBER_WITH_REPORT=OFF",
                f"-DPython_EXECUTABLE={sys.executable}", f"-DLIMBER_ARCH={os.environ.get('LIMBER_ARCH', '')}"
            ] + (["-G", "Ninja"] if shutil.which("ninja") else []))
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
        subprocess.check_call(["cmake", "--build", tree, "--target", "limber_python_package", "--parallel", jobs])
        shutil.copytree(os.path.join(tree, "python", "limber"), os.path.join(self.build_lib, "limber"),
                        ignore=shutil.ignore_patterns("__pycache__"), dirs_exist_ok=True)


setup(version=VERSION, packages=[], distclass=BinaryDistribution, cmdclass={"build": CMakeBuild})
