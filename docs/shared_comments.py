#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Doxygen's input filter: the comment of variables that are declared together is that of each of them.

    double low = 0.0, high = 0.0;  ///< [px]

    shared_comments.py HEADER      prints it with one declaration for each, in the same line
"""
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


def main():
    with open(sys.argv[1], encoding="utf-8") as header:
        lines = joined(header.read().splitlines())
    before = []
    for line in lines:
        print(separated(line, " ".join(before)))
        comment = re.match(r"\s*///(?!<) ?(.*)$", line)
        before = [*before, comment[1]] if comment else []


if __name__ == "__main__":
    main()
