# SPDX-License-Identifier: MIT
"""An example with short recordings for arguments: short_example.py EXAMPLE SCENARIO... [-- ARGUMENT...]"""
import runpy
import sys
import tempfile

from conftest import short

example, *names = sys.argv[1:]
more = []
if "--" in names:
    names, more = names[:names.index("--")], names[names.index("--") + 1:]
with tempfile.TemporaryDirectory() as folder:
    for name in names:
        short(name, 8.0).write(f"{folder}/{name}")
    sys.argv = [example, *(f"{folder}/{name}" for name in names), *more]
    runpy.run_path(example, run_name="__main__")
