#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What Doxygen reads: headers in which the comment of variables that are declared together is that of each of them.

    double low = 0.0, high = 0.0;  ///< [px]

    shared_comments.py HEADERS OUT      copies a folder of headers, with one declaration for each, in the same line
"""
import pathlib
import re
import sys

DECLARATION = re.compile(
    r"^(\s*)((?:const |static |constexpr |inline )*[\w:]+(?:<.*?>)?(?:::\w+)*[*&]? )(\w+[^;]*);\s*(?:///< ?(.*))?$")
NOT_A_TYPE = {"return", "using", "friend", "namespace", "template", "case", "throw", "delete", "goto"}


def parts(text):
    """At the commas that stand in no brackets."""
    depth, begin, found = 0, 0, []
    for i, letter in enumerate(text):
        depth += (letter in "([{<") - (letter in ")]}>")
        if letter == "," and depth == 0:
            found.append(text[begin:i].strip())
            begin = i + 1
    return [*found, text[begin:].strip()]


def separated(line, before):
    """The line with a comment for each variable. before: the comment in the lines above."""
    match = DECLARATION.match(line)
    if not match or match[2].strip() in NOT_A_TYPE:
        return line
    names = parts(match[3])
    comment = match[4] or before
    if len(names) < 2 or not comment or not all(re.match(r"\w+\s*(=|\{|$)", name) for name in names):
        return line
    if match[4]:
        return match[1] + " ".join(f"{match[2]}{name}; /**< {comment} */" for name in names)
    first, *others = names
    return f"{match[1]}{match[2]}{first}; " + " ".join(f"/** {comment} */ {match[2]}{name};" for name in others)


def joined(lines):
    """Declarations and trailing comments of several lines in one, and empty lines in their places."""
    lines = list(lines)
    for i in range(len(lines) - 1, 0, -1):
        declares = re.match(r"\s+[\w:]+(<.*?>)? \w+[^;(/]*,$", lines[i - 1])
        comment = re.match(r"\s*///< ?(.*)$", lines[i])
        if declares:
            lines[i - 1 : i + 1] = [f"{lines[i - 1]} {lines[i].strip()}", ""]
        elif comment and "///<" in lines[i - 1]:
            lines[i - 1 : i + 1] = [f"{lines[i - 1]} {comment[1]}", ""]
    return lines


def rewritten(text):
    """The header, line by line."""
    out, before = [], []
    for line in joined(text.splitlines()):
        out.append(separated(line, " ".join(before)))
        comment = re.match(r"\s*///(?!<) ?(.*)$", line)
        before = [*before, comment[1]] if comment else []
    return "\n".join(out) + "\n"


def main():
    headers, out = map(pathlib.Path, sys.argv[1:])
    for header in sorted(headers.rglob("*.hpp")):
        copy = out / header.relative_to(headers)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(rewritten(header.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
