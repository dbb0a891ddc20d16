#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Verdicts of limber health on pieces of real track logs, as given and with errors added on purpose.

  scripts/pieces_table.py [--data DIR] [--limber PROGRAM] [--seconds S] [--jobs N] [--only NAME]... [--details FILE]

Every track log is cut into pieces of 10 s that do not overlap (a rest that is shorter is left out). Added, one at a time:
0.3 deg on each angle, 3 % of the baseline on each length, either sign; and twice what is wrong on each axis, by turns with
either sign. What an error is worth, `inside` the tolerance, `between` or `outside`, is read from the bands of that axis in the
run with the given calibration, which is taken for true. `named`, and `size within 2 sigma`, are of errors outside and of
the pieces that see that axis (sigma below a third of the error). Nothing is left in the data folder.
"""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import shutil
import tempfile

from verdict_table import AXES, ROOT, UNITS, VERDICTS, run

MARGIN_NS = 200_000_000  # of what is no image: the piece's first and last frame lie within


def stamp(line):
    return int(line.split(",", 1)[0])


def cut(log, out, begin, end):
    """The part of a track log between two stamps."""
    for source in sorted(path for path in log.rglob("*") if path.is_file()):
        target = out / source.relative_to(log)
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.name != "data.csv" or source.parent.name == "landmarks0":
            shutil.copy(source, target)
            continue
        margin = 0 if source.parent.name == "tracks0" else MARGIN_NS
        with source.open() as lines, target.open("w") as kept:
            kept.writelines(line for line in lines if line.startswith("#") or begin - margin <= stamp(line) < end + margin)


def pieces_of(log, seconds):
    with (log / "mav0/tracks0/data.csv").open() as lines:
        stamps = sorted({stamp(line) for line in lines if not line.startswith("#")})
    length = int(seconds * 1e9)
    return [(begin, begin + length) for begin in range(stamps[0], stamps[-1] - length + 1, length)]


def health(limber, recording, error):
    added = ["--assume-error", error] if error else []
    done = run(limber, "health", recording, "--json", *added)
    return json.loads(done.stdout) if done.stdout else {"verdict": "refused", "health": None}


def on_axis(name, value):
    return ",".join(value if axis == name else "0" for axis in AXES)


def worth(size, axis):
    return "inside" if size < axis["ok"] else "outside" if size > axis["wrong"] else "between"


def judge(limber, log, number, piece):
    """All judgements of one piece: (what was added, of what worth, axis, true minus assumed, what health said)."""
    with tempfile.TemporaryDirectory() as folder:
        recording = pathlib.Path(folder) / log.name
        cut(log, recording, *piece)
        given = health(limber, recording, "")
        judged = [("given", "given", "", 0.0, given)]
        if not given["health"]:
            return judged
        baseline = given["health"]["present"]["axes"]["tx"]["ok"] / 0.05  # mm: 5 % of a depth is 5 % of its length
        for k, name in enumerate(AXES):
            axis = given["health"]["present"]["axes"][name]
            size = 0.3 if axis["unit"] == "deg" else 0.03 * baseline
            twice = 2.0 * axis["wrong"] * (1 if (number + k) % 2 else -1)
            for what, value in (("+", size), ("-", -size), ("2x", twice)):
                found = health(limber, recording, on_axis(name, f"{value * UNITS[axis['unit']]:.9g}"))
                judged.append((what, worth(abs(value), axis), name, -value, found))
        return judged


class Tally:
    def __init__(self):
        self.verdicts = collections.Counter()
        self.seen = self.named = self.right = 0

    def add(self, name, truth, found):
        self.verdicts[found["verdict"]] += 1
        if not name or not found["health"]:
            return
        present = found["health"]["present"]
        axis = present["axes"][name]
        if axis["sigma"] < abs(truth) / 3.0:
            self.seen += 1
            self.named += present["most_likely_axis"] == name
            self.right += abs(axis["error"] - truth) <= 2.0 * axis["sigma"]

    def row(self):
        share = [f"{n} of {self.seen}" if self.seen else "–" for n in (self.named, self.right)]
        return " | ".join([*(str(self.verdicts[v]) for v in [*VERDICTS, "refused"]), *share])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    data = os.environ.get("LIMBER_DATA", ROOT.parent / "shared/data")
    parser.add_argument("--data", type=pathlib.Path, default=data)
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--details", type=argparse.FileType("w"), help="one JSON object a line: every judgement")
    arguments = parser.parse_args()
    logs = sorted(path for path in (pathlib.Path(arguments.data) / "track_logs").iterdir() if path.is_dir())
    if not logs:
        raise SystemExit(f"{arguments.data}: no track logs")
    print("| recording | added | " + " | ".join([*VERDICTS, "refused"]) + " | named | size within 2σ |")
    print("| --- " * 9 + "|")
    together = collections.defaultdict(Tally)
    for log in logs:
        if arguments.only and log.name not in arguments.only:
            continue
        tallies = collections.defaultdict(Tally)
        pieces = pieces_of(log, arguments.seconds)
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            for number, judged in enumerate(pool.map(lambda n: judge(arguments.limber, log, n, pieces[n]), range(len(pieces)))):
                for what, level, name, truth, found in judged:
                    for table in (tallies, together):
                        table[level].add(name if level == "outside" else "", truth, found)
                    if arguments.details:
                        print(json.dumps({"recording": log.name, "piece": number, "added": what, "worth": level, "axis": name,
                                          "truth": truth, "found": found}), file=arguments.details, flush=True)
        for level in ("given", "inside", "between", "outside"):
            print(f"| {log.name}, {len(pieces)} | {level} | {tallies[level].row()} |", flush=True)
    for level in ("given", "inside", "between", "outside"):
        print(f"| all | {level} | {together[level].row()} |")


if __name__ == "__main__":
    main()
