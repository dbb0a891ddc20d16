#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What it costs to go frame by frame in Python: processor time of a run by hand (clean, start from the sensors, add_imu, process,
estimate) against limber.run, which does all of it in C++, and against the same loop in C++ (--cpp, track logs alone); by turns, and
the poses of all must be the same, bit by bit.

  PYTHONPATH=build/release/python benchmarks/python_steps.py RECORDING|SCENARIO [--method M] [--turns N] [--cpp build/release/benchmarks/steps]
"""
import argparse
import statistics
import subprocess
import time
from pathlib import Path

import numpy as np

import limber


def by_hand(recording, method):
    options, calibration, _ = limber.set_up(recording, limber.RunOptions(recording, method))
    cleaner = limber.FrameCleaner(calibration)
    frames, imu = limber.frames(recording), recording.imu
    t_imu, begin, states = imu["t_ns"], 0, []
    receiver, navigator = limber.SensorStart(calibration, options), None
    for frame in map(cleaner.clean, frames):
        end = min(int(np.searchsorted(t_imu, frame.t_ns)) + 1, len(t_imu))
        receiver.add_imu(imu[begin:end])
        begin = end
        if navigator is not None:
            navigator.process(frame)
            states.append(navigator.estimate())
        elif receiver.add_frame(frame).status != "waiting":
            receiver = navigator = limber.Navigator(calibration, receiver.result(), options)
            begin = 0
    return np.array([state.p for state in states])


def timed(work):
    begin = time.process_time()
    result = work()
    return time.process_time() - begin, result


def in_cpp(program, recording, method):
    """Its processor time, and where the body is at the end."""
    seconds, *p = map(float, subprocess.run([program, recording, method], check=True, capture_output=True, text=True).stdout.split())
    return seconds, p


def summary(name, times, of):
    ratios = [b / a for a, b in zip(of, times)]
    return f"{name} {statistics.median(times):.2f} s, ratio {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("--method", default="lcekf")
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--cpp", help="the program steps, for a track log")
    arguments = parser.parse_args()
    recording = limber.read(arguments.recording) if Path(arguments.recording).is_dir() else limber.simulate(arguments.recording, seed=1)
    program, hand, cpp = [], [], []
    for _ in range(arguments.turns):
        seconds, run = timed(lambda: limber.run(recording, arguments.method))
        program.append(seconds)
        seconds, p = timed(lambda: by_hand(recording, arguments.method))
        hand.append(seconds)
        if not np.array_equal(p, run.p[-len(p):]):
            raise SystemExit("the poses differ")
        if arguments.cpp:
            seconds, last = in_cpp(arguments.cpp, arguments.recording, arguments.method)
            cpp.append(seconds)
            if last != list(p[-1]):
                raise SystemExit("the last pose of the loop in C++ differs")
    print(f"{len(run.p)} frames, processor time: limber.run {statistics.median(program):.2f} s;", summary("by hand in Python", hand, program))
    if cpp:
        print(f"the loop in C++ {statistics.median(cpp):.2f} s;", summary("in Python", hand, cpp))


if __name__ == "__main__":
    main()
