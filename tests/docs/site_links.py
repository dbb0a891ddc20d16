#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every link of a built docs site leads to a file of it, and to an anchor of that; none was left as text.

    site_links.py HTML_FOLDER
"""
import re
import sys
from functools import cache
from pathlib import Path

OF_DOXYGEN = {"#nested-classes"}  # which it makes for classes whose nested ones have pages of their own


@cache
def anchors_of(file):
    return set(re.findall(r'(?:id|name)="([^"]+)"', file.read_text(errors="replace")))


def dead_links(file, folder):
    text = file.read_text(errors="replace")
    for link in re.findall(r"\]\([\w./-]+\)", text):
        yield f"{file.name}: left as text: {link}"
    for link in re.findall(r'<a [^>]*href="([^"]+)"', text):
        path, _, anchor = link.partition("#")
        there = folder / path if path else file
        if re.match(r"\w+:", link) or link in OF_DOXYGEN:
            continue
        if not there.exists() or (anchor and there.suffix == ".html" and anchor not in anchors_of(there)):
            yield f"{file.name}: {link}"


def main():
    folder = Path(sys.argv[1])
    pages = sorted(folder.glob("*.html"))
    dead = sorted({link for page in pages for link in dead_links(page, folder)})
    print(f"{len(pages)} pages, {len(dead)} dead links")
    sys.exit("\n".join(dead) if dead or not pages else 0)


if __name__ == "__main__":
    main()
