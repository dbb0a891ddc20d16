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


def accuracy_table(results, profiles, rows):
    """ATE and completeness: a row a system with its start, a column a profile."""
    lines = ["| system, start | " + " | ".join(profile or "nothing" for profile in profiles) + " |",
             "| --- |" + " --- |" * len(profiles)]
    for row in rows:
        cells = [accuracy_cell([r for r in results if r["bend"] == profile and (r["system"], r["start"]) == row])
                 for profile in profiles]
        lines.append(f"| {row[0]}, {row[1]} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def repetition_table(results, rows):
    """How far repetitions of one profile differ: in how many profiles not at all, and the largest ratio of two ATE."""
    lines = ["| system, start | repetitions | equal to the bit | ATE, largest / smallest |", "| --- | --- | --- | --- |"]
    for row in rows:
        groups = {}
        for r in results:
            if (r["system"], r["start"]) == row:
                groups.setdefault(r["bend"], []).append(r)
        groups = [runs for runs in groups.values() if len(runs) > 1]
        if not groups:
            continue
        counts = sorted({len(runs) for runs in groups})
        equal = sum(len({r["trajectory"] for r in runs}) == 1 for runs in groups)
        errors = [[r["ate"] for r in runs if r["ate"] is not None] for runs in groups]
        ratio = max((max(ate) / min(ate) for ate in errors if ate), default=None)
        lines.append(f"| {row[0]}, {row[1]} | {', '.join(map(str, counts))} | {equal} of {len(groups)} | "
                     f"{'–' if ratio is None else f'{ratio:.3g}'} |")
    return "\n".join(lines)


def cost_table(results, rows):
    """CPU and memory of a system over all profiles. What decoding takes is the runners' measurement, for all."""
    known = [r["decode_ms"] for r in results if "decode_ms" in r]
    decode = statistics.median(known) if known else None
    lines = ["| system, start | CPU of the process [s] | a frame, with decoding [ms] | without [ms] | peak memory [MB] |",
             "| --- | --- | --- | --- | --- |"]
    for row in rows:
        runs = [r for r in results if (r["system"], r["start"]) == row]
        cpu = statistics.median(r["cpu_s"] for r in runs)
        frame = 1e3 * statistics.median(r["cpu_s"] / r["frames"] for r in runs)
        own = [r["estimate_ms"] for r in runs if "estimate_ms" in r]
        without = f"{statistics.median(own):.1f}" if own else f"≤ {frame - decode:.1f}" if decode is not None else ""
        lines.append(f"| {row[0]}, {row[1]} | {cpu:.2f} | {frame:.1f} | {without} "
                     f"| {max(r['peak_mb'] for r in runs):.0f} |")
    return "\n".join(lines)


def split_table(results, rows):
    """Tracking and filter within one run, on the clock: of each the median over all profiles."""
    lines = ["| system, start | tracking, p50 [ms] | p99 | filter, p50 [ms] | p99 |", "| --- | --- | --- | --- | --- |"]
    for row in rows:
        splits = [r["split"] for r in results if (r["system"], r["start"]) == row and r.get("split")]
        if splits:
            cells = [f"{statistics.median(s[stage][q] for s in splits):.1f}"
                     for stage in ("track_ms", "filter_ms") for q in ("p50", "p99")]
            lines.append(f"| {row[0]}, {row[1]} | {' | '.join(cells)} |")
    return "\n".join(lines)


def tables_of(results):
    """All four, rows and profiles in the order of the results."""
    profiles = list(dict.fromkeys(r["bend"] for r in results))
    rows = list(dict.fromkeys((r["system"], r["start"]) for r in results))
    return "\n\n".join([accuracy_table(results, profiles, rows), repetition_table(results, rows), cost_table(results, rows),
                        split_table(results, rows)])


def tables(results):
    """Those of each recording, under its name."""
    sources = dict.fromkeys(r["source"] for r in results)
    return "\n\n".join(f"{source}\n\n{tables_of([r for r in results if r['source'] == source])}" for source in sources)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        print(tables([r for file in sys.argv[1:] for r in json.loads(pathlib.Path(file).read_text())]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        sys.exit(f"peers_table: {error!r}: expected results.json of compare_peers.py")
