#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the type stubs of the compiled module from the signatures that pybind11 puts into docstrings: stubs.py OUT.

The module is found on PYTHONPATH.
"""
import re
import sys

HEAD = '''# SPDX-License-Identifier: MIT
# Made by python/stubs.py.
import os
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

'''
SIGNATURE = re.compile(r"^(?:\d+\. )?(\w+)\((.*)\) -> (.*)$", re.M)


def split(arguments):
    """At the commas outside of brackets."""
    parts, depth, part = [], 0, ""
    for character in arguments:
        depth += (character in "[(<{") - (character in "])>}")
        if character == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            part += character
    return parts + [part.strip()] if part.strip() else parts


def tidy(annotation, is_argument):
    array = "npt.ArrayLike" if is_argument else "npt.NDArray[Any]"
    annotation = re.sub(r"numpy\.ndarray\[numpy\.(float64|int64)(\[[^]]*\])?\]", array, annotation)
    annotation = re.sub(r"numpy\.ndarray\[numpy\.uint8\]", "npt.NDArray[np.uint8]", annotation)
    annotation = re.sub(r"\bnumpy\.ndarray\b", "npt.NDArray[Any]", annotation)
    annotation = re.sub(r"\b(os\.PathLike)\b", "Union[str, os.PathLike[str]]" if is_argument else "os.PathLike[str]",
                        annotation)
    annotation = annotation.replace("limber._limber.", "").replace("iterator", "Iterator[Any]")
    return {"handle": "Any", "object": "Any", "dict": "Dict[str, Any]", "list": "List[Any]",
            "tuple": "Tuple[Any, ...]"}.get(annotation, annotation)


def argument(text):
    name, _, rest = text.partition(":")
    if not rest:
        return text
    annotation, has_default, _ = rest.partition(" = ")
    if name == "self":
        return "self"
    return f"{name}: {tidy(annotation.strip(), True)}{' = ...' if has_default else ''}"


def doc_block(doc, indent):
    text = re.sub(r"^(?:\d+\. )?\w+\(.*\)(?: -> .*)?$", "", doc or "", flags=re.M).replace("Overloaded function.", "").strip()
    quoted = text.replace("\\", "\\\\").replace('"""', "'''")
    return f'{indent}"""{quoted}"""\n' if quoted else ""


def function(doc, indent):
    found = SIGNATURE.findall(doc or "")
    found = [one for one in found if one[0] != "Overloaded"]
    several = (doc or "").count("Overloaded function.") > 0
    out = ""
    for k, (name, arguments, returned) in enumerate(found if several else found[:1]):
        out += f"{indent}@overload\n" if several else ""
        listed = ", ".join(argument(part) for part in split(arguments))
        out += f"{indent}def {name}({listed}) -> {tidy(returned.strip(), False)}:\n"
        out += (doc_block(doc, indent + "    ") if k == 0 else "") + f"{indent}    ...\n\n"
    return out


def property_of(name, member):
    found = SIGNATURE.search(re.sub(r"^\(", name + "(", member.fget.__doc__ or "", flags=re.M))
    returned = tidy(found.group(3).strip(), False) if found else "Any"
    out = f"    @property\n    def {name}(self) -> {returned}:\n{doc_block(member.__doc__, '        ')}        ...\n\n"
    if member.fset:
        assigned = tidy(found.group(3).strip(), True) if found else "Any"
        out += f"    @{name}.setter\n    def {name}(self, value: {assigned}) -> None: ...\n\n"
    return out


def class_of(name, cls):
    base = {"DataError": "RuntimeError", "DivergenceError": "RuntimeError"}.get(name, "")
    out = f"class {name}{f'({base})' if base else ''}:\n" + doc_block(cls.__doc__, "    ")
    if name == "DataError":
        return out + "    file: str\n    line: int\n\n\n"
    if hasattr(cls, "__members__"):
        return out + "".join(f"    {member}: {name}\n" for member in cls.__members__) + "\n\n"
    for key, member in sorted(vars(cls).items()):
        wanted = key in ("__init__", "__len__", "__iter__", "__next__", "__getitem__", "__matmul__", "__str__")
        if key.startswith("_") and not wanted:
            continue
        if isinstance(member, property):
            out += property_of(key, member)
        elif isinstance(member, staticmethod):
            out += "    @staticmethod\n" + function(member.__func__.__doc__, "    ")
        elif callable(member):
            out += function(member.__doc__, "    ")
    return out + "    ...\n\n\n"


def main(out):
    sys.path.pop(0)  # the folder of this script holds the package's sources
    from limber import _limber as module
    text = HEAD
    for name, member in sorted(vars(module).items()):
        if name.startswith("__"):
            continue
        if isinstance(member, type):
            text += class_of(name, member)
        elif callable(member):
            text += function(member.__doc__, "")
        else:
            text += f"{name}: Tuple[str, ...]\n"
    text += "__version__: str\n"
    with open(out, "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    main(sys.argv[1])
