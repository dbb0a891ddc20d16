#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes docstrings of the comments of C++ headers: docstrings.py OUT HEADER...

`/// ...` before a declaration, and `///< ...` behind one, become constants of namespace limber::doc, named
Class_member or function, for the DOC macro of python/src. An overload adds its text to the first one's.
"""
import re
import sys

WORDS = [("std::invalid_argument", "ValueError"), ("std::runtime_error", "RuntimeError"),
         ("std::logic_error", "RuntimeError"), ("@brief ", ""),
         ("@return ", "Returns "), ("@throws ", "Raises "), ("[[nodiscard]] ", "")]
SCOPE = re.compile(r"^(?:class|struct|enum class|enum) (\w+)[^;]*\{$")
FUNCTION = re.compile(r"(?:^|[\s&*])([A-Za-z]\w*)\(")
MEMBER = re.compile(r"(\w+)\s*(?:=[^;]*|\{[^;]*)?;")
ENUMERATOR = re.compile(r"(k[A-Z]\w*)")
KEYWORDS = {"sizeof", "false", "operator"}


def tidy(lines):
    text = "\n".join(lines)
    for old, new in WORDS:
        text = text.replace(old, new)
    text = re.sub(r"@param(?:\[\w+(?:,\w+)?\])? (\w+) +", r"\1: ", text)
    return re.sub(r"@(note|file).*", "", text).strip()


def name_of(code):
    scope = SCOPE.match(code)
    match = scope or FUNCTION.search(code) or ENUMERATOR.match(code) or MEMBER.search(code)
    return match.group(1) if match and match.group(1) not in KEYWORDS else None


def comments(lines):
    """Yields (qualified name, text) of everything that has a comment."""
    scopes, pending = [], []
    for line in lines:
        indent, code = len(line) - len(line.lstrip()), line.strip()
        if code.startswith("///") and not code.startswith("///<"):
            pending.append(code[3:].removeprefix(" "))
            continue
        while scopes and code.startswith("}") and indent <= scopes[-1][0]:
            scopes.pop()
        code, _, behind = (part.strip() for part in code.partition("///<"))
        code = code.replace("[[nodiscard]] ", "")
        text = tidy(pending + ([behind] if behind else []))
        name = name_of(code) if code and not code.startswith(("namespace", "#")) else None
        if name and text:
            yield "_".join([scope for _, scope in scopes] + [name]), text
        scope = SCOPE.match(code)
        if scope:
            scopes.append((indent, scope.group(1)))
        pending = []


def main(out, headers):
    found = {}
    for header in headers:
        with open(header, encoding="utf-8") as file:
            for name, text in comments(file):
                if text not in found.get(name, ""):
                    found[name] = f"{found[name]}\n\n{text}" if name in found else text
    with open(out, "w", encoding="utf-8") as file:
        file.write("// Made by docstrings.py.\n#pragma once\n#define DOC(name) limber::doc::name\n"
                   "namespace limber::doc {\n")
        for name in sorted(found):
            file.write(f'inline constexpr const char {name}[] = R"doc({found[name]})doc";\n')
        file.write("}  // namespace limber::doc\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
