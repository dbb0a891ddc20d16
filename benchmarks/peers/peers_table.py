#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The tables of one or several results.json of compare_peers.py.

  benchmarks/peers/peers_table.py RESULTS.json...
"""
import json
import pathlib
import statistics
import sys


def accuracy_cell(runs):
    """Median ATE with its range where repetitions differ, and the share of frames with a pose."""
    if not runs:
        return ""
    share = f"{100 * min(r['poses'] / r['frames'] for r in runs):.0f} %"
    errors = [r["ate"] for r in runs if r["ate"] is not None]
    if not errors:
        return f"none · {share}"
    text = f"{statistics.median(errors):.3g}"
    if max(errors) > 1.01 * min(errors):
        text += f" ({min(errors):.2g}–{max(errors):.2g})"
    lost = len(runs) - len(errors)
    return f"{text} · {share}" + (f" · {lost} of {len(runs)} without" if lost else "")


def accuracy_table(results, profiles, columns):
    """ATE and completeness: a row a profile, a column a system with its start."""
    lines = ["| bent by | " + " | ".join(f"{system}, {start}" for system, start in columns) + " |",
             "| --- |" + " --- |" * len(columns)]
    for profile in profiles:
        cells = [accuracy_cell([r for r in results if r["bend"] == profile and (r["system"], r["start"]) == column])
                 for column in columns]
        lines.append(f"| {profile or 'nothing'} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def cost_table(results, columns):
    """CPU and memory of a system over all profiles. What decoding takes is the runner's measurement, for all."""
    known = [r["decode_ms"] for r in results if "decode_ms" in r]
    decode = statistics.median(known) if known else None
    lines = ["| system, start | CPU of the process [s] | a frame, with decoding [ms] | without [ms] | peak memory [MB] |",
             "| --- | --- | --- | --- | --- |"]
    for column in columns:
        runs = [r for r in results if (r["system"], r["start"]) == column]
        cpu = statistics.median(r["cpu_s"] for r in runs)
        frame = 1e3 * statistics.median(r["cpu_s"] / r["frames"] for r in runs)
        own = [r["estimate_ms"] for r in runs if "estimate_ms" in r]
        without = f"{statistics.median(own):.1f}" if own else f"≤ {frame - decode:.1f}" if decode is not None else ""
        lines.append(f"| {column[0]}, {column[1]} | {cpu:.2f} | {frame:.1f} | {without} "
                     f"| {max(r['peak_mb'] for r in runs):.0f} |")
    return "\n".join(lines)


def tables(results):
    """Both, rows and columns in the order of the results."""
    profiles = list(dict.fromkeys(r["bend"] for r in results))
    columns = list(dict.fromkeys((r["system"], r["start"]) for r in results))
    return accuracy_table(results, profiles, columns) + "\n\n" + cost_table(results, columns)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        print(tables([r for file in sys.argv[1:] for r in json.loads(pathlib.Path(file).read_text())]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        sys.exit(f"peers_table: {error!r}: expected results.json of compare_peers.py")
