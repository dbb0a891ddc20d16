#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""limber, OpenVINS and libviso2 on the same images, bent and not, scored by `limber evaluate`.

  benchmarks/peers/compare_peers.py RECORDING [--openvins SOURCE --runner PROGRAM] [--libviso2 PROGRAM] --out NEW_FOLDER

RECORDING is an EuRoC or a KITTI folder. README.md beside this file says how to build the peers and what the rows mean.
"""
import argparse
import hashlib
import json
import os
import pathlib
import subprocess
import sys

import euroc
import libviso2
import openvins
import peers_table
import recordings

ROOT = pathlib.Path(__file__).resolve().parents[2]
BENDS = ["ay=0.5", "ay=1", "ay=2", "ay=3", "ay=5", "ay=0.5,shape=vibration,frequency=1", "ay=2,shape=ramp,end=8"]
SYSTEMS = ["openvins", "openvins-calib", "libviso2", "ekf", "lcekf", "adaptive"]


def measured(command, log):
    """Runs a program: (exit code, CPU seconds of user and system, peak memory in MB)."""
    with open(log, "w") as file:
        process = subprocess.Popen([str(word) for word in command], stdout=file, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def first_causal_ns(folder, first_ns):
    """limber smooths the wait of a start from sensors: poses before its end know the future and are left out."""
    waited = (json.loads((folder / "summary.json").read_text()).get("sensor_start") or {}).get("waited_s") or 0
    return first_ns + round(1e9 * waited) - 1000


def poses_from(trajectory, first_ns=0):
    """Header and rows of a trajectory.csv that are no earlier than first_ns; nothing where there is no such file."""
    lines = trajectory.read_text().splitlines() if trajectory.exists() else []
    return lines[:1] + [line for line in lines[1:] if int(line.split(",")[0]) >= first_ns]


def limber_poses(folder, first_ns):
    """The causal ones of a run's folder, as poses_from gives them."""
    done = (folder / "summary.json").exists()
    return poses_from(folder / "trajectory.csv", first_causal_ns(folder, first_ns)) if done else []


def evaluation(limber, poses, folder, recording):
    """What `limber evaluate` says of these poses, written to the folder; None of fewer than three."""
    if len(poses) < 4:
        return None
    scored = folder / "causal.csv"
    scored.write_text("\n".join(poses) + "\n")
    done = subprocess.run([limber, "evaluate", scored, recording, "--json"], capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else None


def limber_options(recording, method, start, points):
    """On one thread; matched points need none to themselves, and are thinned where images are tracked less."""
    has_images = recordings.has_images(recording)
    options = ["--method", method, "--init", "groundtruth" if start == "truth" else "auto"]
    options += ["--threads", "1"] if has_images else []
    return options + (["--max-tracks" if has_images else "--max-points", str(points)] if points else [])


def run_limber(arguments, recording, folder, method, start, _):
    options = limber_options(recording, method, start, arguments.points)
    settings = " ".join(options) + digest(arguments.limber)
    code, cpu_s, peak_mb = measured([arguments.limber, "run", recording, *options, "--out", folder / "run"], folder / "log.txt")
    poses = limber_poses(folder / "run", recordings.stereo_stamps(recording)[0])
    result = {"exit": code, "cpu_s": cpu_s, "peak_mb": peak_mb, "settings": hashed(settings)}
    return result | {"split": limber_split(folder / "run")}, poses


def limber_split(folder):
    """As openvins.split: tracking and filter of a frame, p50 and p99 on the clock; None of a run that has not ended."""
    summary = folder / "summary.json"
    times = json.loads(summary.read_text())["ms_per_frame"] if summary.exists() else {}
    return {"track_ms": times["track"], "filter_ms": times} if "track" in times else None


def reported(log):
    """What a runner says of itself in its last line."""
    return json.loads(log.read_text().splitlines()[-1])


def run_openvins(arguments, recording, folder, system, start, _):
    calibrate = system == "openvins-calib"
    config, state, changed = openvins.write_settings(arguments.openvins / "config/euroc_mav", recording, folder,
                                                     calibrate, start, arguments.points)
    trajectory = folder / "trajectory.csv"
    code, cpu_s, peak_mb = measured([arguments.runner, "run", config, recording, trajectory, *([state] if state else [])],
                                    folder / "log.txt")
    settings = "".join(file.read_text() for file in sorted(folder.glob("*.yaml"))).replace(str(folder), "")
    result = {"exit": code, "cpu_s": cpu_s, "peak_mb": peak_mb, "settings": hashed(settings + digest(arguments.runner)),
              "changed": changed, "split": openvins.split(folder)}
    if code == 0:
        result.update(reported(folder / "log.txt"))
    return result, poses_from(trajectory)


def run_libviso2(arguments, recording, folder, _, __, repetition):
    """Each repetition has a seed of its own for its RANSAC; 1 is the one that the library takes."""
    calibration, pairs = libviso2.write_inputs(recording, folder)
    trajectory = folder / "trajectory.csv"
    seed = 1 + repetition
    code, cpu_s, peak_mb = measured([arguments.libviso2, calibration, pairs, trajectory, seed], folder / "log.txt")
    settings = hashed(calibration.read_text() + digest(arguments.libviso2))
    result = {"exit": code, "cpu_s": cpu_s, "peak_mb": peak_mb, "settings": settings, "seed": seed}
    if code == 0:
        result.update(reported(folder / "log.txt"))
    return result, poses_from(trajectory)


def digest(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def hashed(text):
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def runner_of(system):
    return run_openvins if system.startswith("openvins") else run_libviso2 if system == "libviso2" else run_limber


def run(arguments, recording, folder, system, start, repetition):
    """One run of one system, scored."""
    folder.mkdir(parents=True)
    result, poses = runner_of(system)(arguments, recording, folder, system, start, repetition)
    scored = evaluation(arguments.limber, poses, folder, recording)
    result.update({"system": system, "start": start, "recording": recording.name, "poses": max(0, len(poses) - 1)})
    result.update({"frames": len(recordings.stereo_stamps(recording)), "ate": scored["ate_m"]["se3"] if scored else None})
    result.update({"source": arguments.recording.name, "repetition": repetition, "trajectory": hashed("\n".join(poses))})
    return result


def bend(arguments, profile):
    """The recording, bent once."""
    if not profile:
        return arguments.recording
    folder = arguments.out / "recordings" / profile
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run([arguments.limber, "decalibrate", arguments.recording, "--as", profile, "--out", folder], check=True,
                       stdout=subprocess.DEVNULL)
    return folder


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("--openvins", type=pathlib.Path, help="source tree of OpenVINS, for its EuRoC settings")
    parser.add_argument("--runner", type=pathlib.Path, help="openvins_runner, built")
    parser.add_argument("--libviso2", type=pathlib.Path, help="libviso2_runner, built")
    parser.add_argument("--limber", type=pathlib.Path, default=ROOT / "build/release/limber")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="new folder for recordings, runs and results.json")
    parser.add_argument("--bend", action="append", metavar="PROFILE", help="as in limber decalibrate --as; may be repeated; "
                        f"'' bends nothing; default: '' and {' '.join(BENDS)}")
    parser.add_argument("--systems", help=f"some of {','.join(SYSTEMS)}; default: those whose programs are given, and limber")
    parser.add_argument("--start", choices=["truth", "own", "both"], default="both", help="default: %(default)s")
    parser.add_argument("--points", type=int, help="points a camera, for all; default: what each system has for EuRoC")
    parser.add_argument("--repeat", type=int, default=5, help="default: %(default)s")
    arguments = parser.parse_args()
    if arguments.systems is None:
        arguments.systems = ",".join(system for system in SYSTEMS if not missing(arguments, system))
    check(parser, arguments)
    for name in ("recording", "out", "limber", "runner", "openvins", "libviso2"):
        if getattr(arguments, name):
            setattr(arguments, name, getattr(arguments, name).resolve())
    return arguments


def missing(arguments, system):
    """The options without which a peer cannot run."""
    needed = ["openvins", "runner"] if system.startswith("openvins") else ["libviso2"] if system == "libviso2" else []
    return [f"--{name}" for name in needed if getattr(arguments, name) is None]


def check(parser, arguments):
    systems = arguments.systems.split(",")
    unknown = set(systems) - set(SYSTEMS)
    if unknown:
        parser.error(f"--systems: {', '.join(sorted(unknown))}: expected some of {', '.join(SYSTEMS)}")
    for system in systems:
        if missing(arguments, system):
            parser.error(f"{system} needs {' and '.join(missing(arguments, system))}")
        if system.startswith("openvins") and not recordings.has_imu(arguments.recording):
            parser.error(f"{system} needs an IMU, and {arguments.recording} has none")
    settings = arguments.openvins / "config/euroc_mav" if arguments.openvins else None
    for path in (arguments.recording, arguments.limber, arguments.runner, settings, arguments.libviso2):
        if path and not path.exists():
            parser.error(f"{path} is not there")
    if arguments.repeat < 1:
        parser.error("--repeat: expected 1 or more")
    if arguments.out.exists() and any(arguments.out.iterdir()):
        parser.error(f"{arguments.out} is not empty: nothing is ever replaced")


def columns(systems, starts):
    """[(system, start)]: libviso2 needs no start, and runs once."""
    return list(dict.fromkeys((system, "none" if system == "libviso2" else start) for start in starts for system in systems))


def main():
    arguments = parse()
    arguments.out.mkdir(parents=True, exist_ok=True)
    profiles = arguments.bend if arguments.bend is not None else ["", *BENDS]
    starts = ["truth", "own"] if arguments.start == "both" else [arguments.start]
    results = []
    for profile in profiles:
        recording = bend(arguments, profile)
        for repetition in range(arguments.repeat):
            for system, start in columns(arguments.systems.split(","), starts):
                folder = arguments.out / "runs" / (profile or "nothing") / f"{system}-{start}-{repetition}"
                results.append({"bend": profile, **run(arguments, recording, folder, system, start, repetition)})
                (arguments.out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    print(peers_table.tables(results))


if __name__ == "__main__":
    try:
        main()
    except (euroc.Malformed, OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"compare_peers: {error}")
