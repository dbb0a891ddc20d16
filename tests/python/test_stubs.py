# SPDX-License-Identifier: MIT
import ast
import pathlib

import limber
from limber import _limber

PACKAGE = pathlib.Path(limber.__file__).parent
STUB = ast.parse((PACKAGE / "_limber.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}


def arguments_of(function):
    return [a.arg for a in function.args.args + function.args.kwonlyargs]


def test_stubs_name_everything_that_the_module_has():
    functions = {node.name for node in STUB.body if isinstance(node, ast.FunctionDef)}
    for name, member in vars(_limber).items():
        if name.startswith("__"):
            continue
        if isinstance(member, type):
            methods = {n.name for n in CLASSES[name].body if isinstance(n, ast.FunctionDef)}
            public = {key for key in vars(member) if not key.startswith("_")} - {"name", "value"}
            if not hasattr(member, "__members__"):
                assert public <= methods | {"name"}, name
        elif callable(member):
            assert name in functions


def test_stubs_have_signatures_types_and_docs():
    methods = [n for n in CLASSES["Navigator"].body if isinstance(n, ast.FunctionDef)]
    process, = [n for n in methods if n.name == "process"]
    assert arguments_of(process) == ["self", "frame"] and process.returns.id == "FrameReport"
    assert "older than the state" in ast.get_docstring(process)
    assert [arguments_of(n) for n in methods if n.name == "add_imu"] == [["self", "t_ns", "omega", "accel"],
                                                                       ["self", "samples"]]
    options, = [n for n in CLASSES["RunOptions"].body if getattr(n, "name", "") == "__init__"]
    assert {"constraints", "assume_error", "false_alarms"} <= set(arguments_of(options))


def test_everything_public_has_a_docstring():
    for name in limber.__all__:
        assert name == "PARAMETER_NAMES" or getattr(limber, name).__doc__, name
    assert (PACKAGE / "py.typed").exists()
