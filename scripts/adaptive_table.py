#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How `adaptive` fares beside the best of the other methods, from study databases.

    limber study scenarios/paper_i.yaml ... --methods ekf,ekf-full,lcekf,mono-left,adaptive --init groundtruth --runs 50 --out study.sqlite
    scripts/adaptive_table.py study.sqlite ...

Prints a Markdown table: position RMSE in metres (root of the mean square over runs), the ratio of adaptive to the best
of the others with its 95 % interval (bootstrap over runs, paired, the best method chosen once), and adaptive's ANEES.
"""
import argparse
import math
import random
import sqlite3
import sys

RIVALS = ["ekf", "ekf-full", "lcekf", "mono-left"]
DRAWS = 2000


def read_runs(path):
    """{case: {method: {run: (rmse, anees) or None where it diverged}}}"""
    query = """select c.name, m.label, r.run, r.position_rmse_m, r.anees from runs r
               join cases c on c.id = r.case_id join methods m on m.case_id = r.case_id and m.method = r.method"""
    cases = {}
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as database:
        for case, method, run, rmse, anees in database.execute(query):
            value = None if rmse is None else (rmse, anees)
            cases.setdefault(case, {}).setdefault(method, {})[run] = value
    return cases


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def interval(adaptive, best, generator):
    """95 % interval of rms(adaptive) / rms(best) over runs drawn with replacement, the same for both."""
    n = len(adaptive)
    ratios = []
    for _ in range(DRAWS):
        drawn = [generator.randrange(n) for _ in range(n)]
        ratios.append(rms([adaptive[k] for k in drawn]) / rms([best[k] for k in drawn]))
    ratios.sort()
    return ratios[int(0.025 * DRAWS)], ratios[int(0.975 * DRAWS)]


def row(case, methods, generator):
    runs = sorted(methods["adaptive"])
    diverged = {m: sum(methods[m].get(k) is None for k in runs) for m in methods}
    usable = [m for m in RIVALS if m in methods and not diverged[m]]
    text = {}
    for m in RIVALS + ["adaptive"]:
        values = [methods[m][k][0] for k in runs if m in methods and methods[m].get(k)]
        text[m] = f"{rms(values):.4f}" if values else "–"
        if diverged.get(m):
            text[m] += f" ({diverged[m]} diverged)"
    if diverged["adaptive"] or not usable:
        ratio, verdict = "–", "misses"
        anees = float("nan")
    else:
        best = min(usable, key=lambda m: rms([methods[m][k][0] for k in runs]))
        adaptive = [methods["adaptive"][k][0] for k in runs]
        rival = [methods[best][k][0] for k in runs]
        low, high = interval(adaptive, rival, generator)
        value = rms(adaptive) / rms(rival)
        anees = sum(methods["adaptive"][k][1] for k in runs) / len(runs)
        ratio = f"{value:.2f} ({low:.2f}–{high:.2f})"
        verdict = "" if value <= 1.05 and 0.7 <= anees <= 1.4 else "misses"
    cells = [text[m] for m in RIVALS] + [text["adaptive"], ratio, f"{anees:.2f}", verdict]
    return f"| {case} | " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("databases", nargs="+", metavar="STUDY.sqlite")
    arguments = parser.parse_args()
    generator = random.Random(1)
    print("| case | " + " | ".join(RIVALS) + " | adaptive | of the best (95 %) | ANEES | |")
    print("|" + " --- |" * (len(RIVALS) + 5))
    for path in arguments.databases:
        try:
            cases = read_runs(path)
        except sqlite3.Error as error:
            sys.exit(f"adaptive_table: {path}: {error}")
        for case, methods in cases.items():
            if "adaptive" in methods:
                print(row(case, methods, generator))


if __name__ == "__main__":
    main()
