#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints one table from the summary.json files of `limber run`: a line per run.

A run's case is the name of the folder that holds its output folder: CASE/METHOD/summary.json.
"""
import argparse
import json
import os
import sys
from pathlib import Path

COLUMNS = ["case", "method", "position RMSE [m]", "attitude RMSE [deg]", "ANEES", "x real time", "output"]


def shown(summary, key, digits):
    """The number under `key`, or '-' where the run could not know it."""
    value = summary[key]
    return "-" if value is None else f"{value:.{digits}f}"


def row(path):
    summary = json.loads(path.read_text())
    return [
        path.parent.parent.name,
        summary["method"],
        shown(summary, "position_rmse_m", 3),
        shown(summary, "attitude_rmse_deg", 3),
        shown(summary, "anees", 2),
        shown(summary, "realtime_factor", 1),
        os.path.relpath(path.parent),
    ]


def table(rows):
    widths = [max(len(line[k]) for line in [COLUMNS, *rows]) for k in range(len(COLUMNS))]
    numbers = range(2, len(COLUMNS) - 1)

    def text(line):
        cells = [cell.rjust(w) if k in numbers else cell.ljust(w) for k, (cell, w) in enumerate(zip(line, widths))]
        return "  ".join(cells).rstrip()

    return [text(COLUMNS), "  ".join("-" * w for w in widths), *map(text, rows)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("summaries", metavar="SUMMARY_JSON", nargs="+", type=Path)
    rows = []
    for path in parser.parse_args().summaries:
        try:
            rows.append(row(path))
        except (OSError, ValueError, KeyError, TypeError) as error:
            sys.exit(f"{path}: not the summary of a run ({type(error).__name__}: {error})")
    print("\n".join(table(rows)))
    print("\nANEES: normalised estimation error squared of the pose per degree of freedom; 1 is consistent.")


if __name__ == "__main__":
    main()
