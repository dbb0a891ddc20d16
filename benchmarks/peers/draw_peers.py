#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""ATE and completeness against degrees of decalibration, of one or several results.json of compare_peers.py.

  benchmarks/peers/draw_peers.py RESULTS.json... --out PICTURE.svg

Needs matplotlib (Debian: python3-matplotlib).
"""
import argparse
import json
import pathlib
import re
import statistics
import sys

STYLES = {"openvins": ("#999999", "s", "OpenVINS"), "openvins-calib": ("#444444", "D", "OpenVINS, online calibration"),
          "libviso2": ("#cc79a7", "P", "libviso2"),
          "ekf": ("#d55e00", "v", "ekf"), "lcekf": ("#0072b2", "o", "lcekf"), "adaptive": ("#009e73", "^", "adaptive")}


def degrees(profile):
    """Of a constant vergence; None of a profile that moves or turns otherwise."""
    found = re.fullmatch(r"ay=(-?[\d.]+)", profile)
    return 0.0 if profile == "" else float(found.group(1)) if found else None


def label(profile):
    """A moving profile in words, short enough for a tick."""
    keys = dict(pair.split("=") for pair in profile.split(","))
    if keys.get("shape") == "vibration":
        return f"±{keys['ay']}°\n{keys['frequency']} Hz"
    if keys.get("shape") == "ramp":
        return f"0→{keys['ay']}°\nin {keys['end']} s"
    return profile.replace(",", "\n")


def places(profiles):
    """[(profile, where on the axis, text of its tick)]: degrees first, then profiles that move, one beside the other."""
    constant = sorted((degrees(p), p) for p in profiles if degrees(p) is not None)
    moving = [p for p in profiles if degrees(p) is None]
    span = constant[-1][0] - constant[0][0] if constant else 0.0
    step = max(0.8, 0.24 * span)
    beyond = (constant[-1][0] if constant else 0.0) + max(1.0, step)
    return ([(p, x, f"{x:g}") for x, p in constant]
            + [(p, beyond + step * i, label(p)) for i, p in enumerate(moving)])


def panels(results):
    """[(recording, start)], one a panel. What needs no start stands in each panel of its recording, alone where there is no other."""
    found = list(dict.fromkeys((r["source"], r["start"]) for r in results))
    started = {source for source, start in found if start != "none"}
    return [(source, start) for source, start in found if start != "none" or source not in started]


def medians(results, system, start, value):
    """{profile: median over the repetitions that have the value}"""
    found = {}
    for r in results:
        if r["system"] == system and r["start"] in (start, "none") and value(r) is not None:
            found.setdefault(r["bend"], []).append(value(r))
    return {profile: statistics.median(values) for profile, values in found.items()}


def drawn_error(result):
    return None if result["ate"] is None else min(result["ate"], LOST_M)


def draw_lines(axes, results, start, ticks, value):
    for system, (colour, marker, name) in STYLES.items():
        known = medians(results, system, start, value)
        constant = [(x, known[p]) for p, x, _ in ticks if p in known and degrees(p) is not None]
        moving = [(x, known[p]) for p, x, _ in ticks if p in known and degrees(p) is None]
        if known:
            axes.plot(*zip(*constant), color=colour, marker=marker, markersize=5, linewidth=1.4, label=name)
        if moving:
            axes.plot(*zip(*moving), color=colour, marker=marker, markersize=5, linewidth=0)
    axes.set_xticks([x for _, x, _ in ticks], [text for _, _, text in ticks], fontsize=8)
    axes.grid(True, color="#dddddd", linewidth=0.6)


LOST_M = 100  # errors beyond it are drawn there, lest one of kilometres flattens the rest
STARTS = {"truth": "start from the truth", "own": "own start", "none": "no start"}


def draw(results, out):
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "limber"
    from matplotlib import pyplot
    shown = panels(results)
    figure, rows = pyplot.subplots(2, len(shown), figsize=(3.4 * len(shown), 5.2), sharex="col", squeeze=False,
                                   height_ratios=[2.2, 1])
    names = {}
    for (source, start), above, below in zip(shown, *rows):
        own = [r for r in results if r["source"] == source]
        ticks = places(list(dict.fromkeys(r["bend"] for r in own)))
        draw_lines(above, own, start, ticks, drawn_error)
        draw_lines(below, own, start, ticks, lambda r: 100 * r["poses"] / r["frames"])
        above.set_yscale("log")
        above.set_ylim(top=1.5 * LOST_M)
        above.set_title(f"{source}, {STARTS[start]}", fontsize=10)
        below.set_ylim(0, 105)
        below.set_xlabel("vergence [°], constant | rigs that move", fontsize=9)
        names.update(zip(*reversed(above.get_legend_handles_labels())))
    rows[0][0].set_ylabel(f"ATE, SE(3) [m], at most {LOST_M}", fontsize=9)
    rows[1][0].set_ylabel("frames with a pose [%]", fontsize=9)
    figure.legend(names.values(), names.keys(), loc="upper center", ncols=6, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 0.94))
    figure.savefig(out, metadata={"Date": None} if out.suffix == ".svg" else None, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=pathlib.Path, nargs="+")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="a name ending with .svg or .png")
    arguments = parser.parse_args()
    if arguments.out in arguments.results or arguments.out.suffix not in (".svg", ".png"):
        parser.error("--out: expected a new name ending with .svg or .png")
    draw([r for file in arguments.results for r in json.loads(file.read_text())], arguments.out)


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError, KeyError, TypeError) as error:
        sys.exit(f"draw_peers: {error!r}: expected results.json of compare_peers.py")
