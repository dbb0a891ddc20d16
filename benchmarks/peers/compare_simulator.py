#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""limber and OpenVINS in the world of OpenVINS' own simulator, its right camera bent, scored by `limber evaluate`.

  benchmarks/peers/compare_simulator.py --openvins SOURCE --programs BUILD_FOLDER --out FOLDER

Runs that OUT holds already are kept: the command can be stopped and repeated. README.md beside this file says more.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys

import compare_peers
import euroc
import openvins

BENDS = {
    "exact": "",
    "constant": "ax=0.01,ay=-0.05,az=0.1,tx=5%,ty=-0.5%,tz=0.25%",
    "step": "tx=25%,shape=ramp,start=85,end=85.001",
    "wave": "tx=25%,shape=square_wave,period=1",
    "sine": "tx=25%,shape=vibration,frequency=0.01",
}
SYSTEMS = [system for system in compare_peers.SYSTEMS if system != "libviso2"]  # it reads images alone
COLUMNS = [("openvins", "truth"), ("openvins-calib", "truth"), ("ekf", "auto"), ("lcekf", "auto"), ("adaptive", "auto")]


def simulated(arguments, seed):
    """The exact recording of a seed, simulated once."""
    folder = arguments.out / "recordings" / f"{arguments.trajectory}-{seed}-exact"
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        new = folder.with_name(folder.name + ".partial")
        subprocess.run([arguments.programs / "openvins_simulation", arguments.openvins / "config/rpng_sim/estimator_config.yaml",
                        arguments.openvins / "ov_data/sim" / f"{arguments.trajectory}.txt", str(seed), new], check=True,
                       stdout=subprocess.DEVNULL)
        new.rename(folder)
    return folder


def bent(arguments, seed, name):
    exact = simulated(arguments, seed)
    folder = exact.with_name(f"{arguments.trajectory}-{seed}-{name}")
    if not folder.exists():
        subprocess.run([arguments.limber, "decalibrate", exact, "--as", BENDS[name], "--out", folder], check=True,
                       stdout=subprocess.DEVNULL)
    return folder


def run_openvins(arguments, recording, folder, system):
    """Header and rows of its trajectory, and the CPU time of its estimator for a frame [ms]."""
    trajectory, log = folder / "trajectory.csv", folder / "log.txt"
    if not (log.exists() and log.read_text().rstrip().endswith("}")):
        config, state, _ = openvins.write_settings(arguments.openvins / "config/rpng_sim", recording, folder,
                                                   system == "openvins-calib", "truth", None)
        compare_peers.measured([arguments.programs / "openvins_runner", "run", config, recording, trajectory, state], log)
    if not log.read_text().rstrip().endswith("}"):
        return [], None
    return compare_peers.poses_from(trajectory), json.loads(log.read_text().splitlines()[-1])["estimate_ms"]


def run_limber(arguments, recording, folder, method, start):
    """The same; the time is the median of a frame on the clock."""
    if not (folder / "run/summary.json").exists():
        points = ["--max-points", str(arguments.points)] if arguments.points else []
        compare_peers.measured([arguments.limber, "run", recording, "--method", method, "--init", start, *points, "--out",
                                folder / "run"], folder / "log.txt")
    poses = compare_peers.limber_poses(folder / "run", euroc.stereo_stamps(recording)[0])
    return poses, json.loads((folder / "run/summary.json").read_text())["ms_per_frame"]["p50"] if poses else None


def scores(evaluation, start):
    """ATE after SE(3), position RMSE [m] and ANEES per degree of freedom, both as the start allows: unaligned from the truth."""
    if evaluation is None:
        return {"ate": None, "position": None, "anees": None, "anees_position": None}
    alignment = "none" if start in ("truth", "groundtruth") else "first_pose"
    anees = evaluation["anees"][alignment]
    return {"ate": evaluation["ate_m"]["se3"], "position": evaluation["ape"][alignment]["translation_m"]["rmse"],
            "anees": anees["pose"], "anees_position": anees["position"]}


def run(arguments, seed, name, system, start):
    recording = bent(arguments, seed, name)
    points = f"-{arguments.points}" if arguments.points and not system.startswith("openvins") else ""
    folder = arguments.out / "runs" / f"{recording.name}-{system}-{start}{points}"
    folder.mkdir(parents=True, exist_ok=True)
    if system.startswith("openvins"):
        poses, frame_ms = run_openvins(arguments, recording, folder, system)
    else:
        poses, frame_ms = run_limber(arguments, recording, folder, system, start)
    evaluation = compare_peers.evaluation(arguments.limber, poses, folder, recording)
    return {"seed": seed, "bend": name, "system": system, "start": start, "frame_ms": frame_ms, **scores(evaluation, start)}


def spread(values):
    """Median, with the range where there are several; '–' for a run without poses or with a broken covariance."""
    known = [value for value in values if value is not None]
    if not known:
        return "–"
    text = f"{statistics.median(known):.2g}"
    if len(known) > 1:
        text += f" ({min(known):.2g}–{max(known):.2g})"
    return text + (f", {len(values) - len(known)} without" if len(known) < len(values) else "")


def table(results, error, anees):
    """A row a bend, a column a system with its start: median error and ANEES over the seeds."""
    columns = list(dict.fromkeys((r["system"], r["start"]) for r in results))
    lines = ["| right camera | " + " | ".join(f"{system}, {start}" for system, start in columns) + " |",
             "| --- |" + " --- |" * len(columns)]
    for name in dict.fromkeys(r["bend"] for r in results):
        cells = []
        for column in columns:
            runs = [r for r in results if r["bend"] == name and (r["system"], r["start"]) == column]
            cells.append(f"{spread([r[error] for r in runs])} · {spread([r[anees] for r in runs])}" if runs else "")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def tables(results):
    return ("ATE after SE(3) [m] · ANEES of the pose\n\n" + table(results, "ate", "anees")
            + "\n\nPosition RMSE [m] · ANEES of the position\n\n" + table(results, "position", "anees_position"))


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--openvins", type=pathlib.Path, required=True, help="source tree of OpenVINS: settings, trajectories")
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="folder of openvins_simulation and openvins_runner")
    parser.add_argument("--limber", type=pathlib.Path, default=compare_peers.ROOT / "build/release/limber")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for recordings, runs and results.json")
    parser.add_argument("--trajectory", default="udel_gore", help="of OpenVINS' ov_data/sim; default: %(default)s")
    parser.add_argument("--seeds", default="1,2,3", help="of map and noise; default: %(default)s")
    parser.add_argument("--bends", default=",".join(BENDS), help="default: %(default)s")
    parser.add_argument("--points", type=int, help="limber's --max-points, of 260 that the simulator gives; default: its own")
    parser.add_argument("--systems", default=",".join(f"{system}:{start}" for system, start in COLUMNS),
                        help="SYSTEM:START,...; starts are auto and groundtruth, of OpenVINS truth; default: %(default)s")
    arguments = parser.parse_args()
    possible = [(system, start) for system in SYSTEMS
                for start in (("truth",) if system.startswith("openvins") else ("auto", "groundtruth"))]
    arguments.columns = [tuple(column.split(":")) for column in arguments.systems.split(",")]
    if not set(arguments.columns) <= set(possible):
        parser.error(f"--systems: expected some of {','.join(':'.join(column) for column in possible)}")
    arguments.seeds, arguments.bends = [int(seed) for seed in arguments.seeds.split(",")], arguments.bends.split(",")
    if not set(arguments.bends) <= set(BENDS):
        parser.error(f"--bends: expected some of {', '.join(BENDS)}")
    for name in ("out", "limber", "programs", "openvins"):
        setattr(arguments, name, getattr(arguments, name).resolve())
    for path in (arguments.limber, arguments.programs / "openvins_simulation", arguments.openvins / "config/rpng_sim"):
        if not path.exists():
            parser.error(f"{path} is not there")
    return arguments


def main():
    arguments = parse()
    arguments.out.mkdir(parents=True, exist_ok=True)
    results = []
    for seed in arguments.seeds:
        for name in arguments.bends:
            for system, start in arguments.columns:
                results.append(run(arguments, seed, name, system, start))
                (arguments.out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    print(tables(results))


if __name__ == "__main__":
    try:
        main()
    except (euroc.Malformed, OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"compare_simulator: {error}")
