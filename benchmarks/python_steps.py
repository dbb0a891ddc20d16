#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What it costs to go frame by frame in Python: processor time of a run by hand (clean, start from the sensors, add_imu, process,
estimate) against limber.run, which does all of it in C++; by turns, and the poses of both must be the same, bit by bit.

  PYTHONPATH=build/release/python benchmarks/python_steps.py RECORDING|SCENARIO [--method M] [--turns N]
"""
import argparse
import statistics
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("--method", default="lcekf")
    parser.add_argument("--turns", type=int, default=7)
    arguments = parser.parse_args()
    recording = limber.read(arguments.recording) if Path(arguments.recording).is_dir() else limber.simulate(arguments.recording, seed=1)
    program, hand, ratios = [], [], []
    for _ in range(arguments.turns):
        ours, run = timed(lambda: limber.run(recording, arguments.method))
        theirs, p = timed(lambda: by_hand(recording, arguments.method))
        if not np.array_equal(p, run.p[-len(p):]):
            raise SystemExit("the poses differ")
        program.append(ours)
        hand.append(theirs)
        ratios.append(theirs / ours)
    print(f"{len(run.p)} frames: limber.run {statistics.median(program):.2f} s, by hand {statistics.median(hand):.2f} s of processor time; "
          f"ratio {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")


if __name__ == "__main__":
    main()
