#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A page for users fits on two screens: at most 120 rows of 100 columns, a longer line counting as several.

    page_lengths.py [FOLDER]      default: docs of the source tree; its sub-folders (derivations, evidence) may be longer
"""
import sys
from pathlib import Path

ROWS, COLUMNS = 120, 100
FOLDER = Path(__file__).resolve().parents[2] / "docs"


def rows(page):
    return sum(max(1, -(-len(line) // COLUMNS)) for line in page.read_text().splitlines())


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    pages = sorted(folder.glob("*.md"))
    long = [f"{page.name}: {rows(page)} rows, at most {ROWS} are two screens" for page in pages if rows(page) > ROWS]
    print(f"{len(pages)} pages, {len(long)} too long")
    sys.exit("\n".join(long) if long or not pages else 0)


if __name__ == "__main__":
    main()
