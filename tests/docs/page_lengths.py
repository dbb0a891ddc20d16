#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A page for users fits on two screens: at most 120 rows of 100 columns, a longer line counting as several. README.md, which
shows code and results as well, on three. Derivations and evidence may be longer.

    page_lengths.py [FOLDER]      default: the source tree
"""
import sys
from pathlib import Path

ROWS, ROWS_OF_README, COLUMNS = 120, 180, 100
SOURCE = Path(__file__).resolve().parents[2]


def rows(page):
    return sum(max(1, -(-len(line) // COLUMNS)) for line in page.read_text().splitlines())


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else SOURCE
    pages = {page: ROWS for page in sorted((folder / "docs").glob("*.md"))}
    pages |= {page: ROWS_OF_README for page in folder.glob("README.md")}
    long = [f"{page.name}: {rows(page)} rows, at most {most}" for page, most in pages.items() if rows(page) > most]
    print(f"{len(pages)} pages, {len(long)} too long")
    sys.exit("\n".join(long) if long or not pages else 0)


if __name__ == "__main__":
    main()
