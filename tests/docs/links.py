#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every link between the documentation's files leads somewhere: to a file of the tree, and to a heading of it.

    links.py [FOLDER]      default: the source tree. Addresses on the web are not looked at.
"""
import re
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]


def prose(text):
    """Without code, in which brackets are no links."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    return re.sub(r"`[^`\n]*`", lambda code: "x" * len(code.group()), text)


def anchor(heading):
    """As GitHub makes them."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")


def anchors_of(file):
    text = re.sub(r"^```.*?^```", "", file.read_text(), flags=re.M | re.S)
    return {anchor(heading) for heading in re.findall(r"^#+ (.*)$", text, re.M)}


def dead_links(file, root):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(file.read_text())):
        if re.match(r"\w+:", target):
            continue
        path, _, fragment = target.partition("#")
        there = (file.parent / path).resolve() if path else file
        if not there.exists():
            yield f"{file.relative_to(root)}: no file {target}"
        elif fragment and there.suffix == ".md" and fragment not in anchors_of(there):
            yield f"{file.relative_to(root)}: no heading {target}"


def pages_of(root):
    alone = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "scenarios/README.md", "ros/README.md", "benchmarks/peers/README.md"]
    return [page for page in [*(root / name for name in alone), *sorted((root / "docs").rglob("*.md"))] if page.exists()]


def main():
    root = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else SOURCE
    pages = pages_of(root)
    dead = [link for page in pages for link in dead_links(page, root)]
    print(f"{len(pages)} pages, {len(dead)} dead links")
    sys.exit("\n".join(dead) if dead else 0)


if __name__ == "__main__":
    main()
