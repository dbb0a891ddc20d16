#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Plays a bag to the node with ROS 1's own rosbag, and compares what the node publishes with `limber run` on that bag: the
same poses, bit by bit, from the frame after the start on.

    node_test.py LIMBER_NODE LIMBER BAG CALIBRATION [--imu IMU_YAML] [--inputs imu|odometry|twist|twist_with_covariance]

A bag of `limber convert` holds twists; for the others they are put into another bag in their type.
"""
import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    import rosbag
    import rosgraph
    from geometry_msgs.msg import TwistWithCovarianceStamped
    from nav_msgs.msg import Odometry
    import rospy  # noqa: F401 (rosbag play's messages)
except ImportError as missing:
    print(f"skipped: needs Debian's python3-rosbag and python3-rosmaster: {missing}")
    sys.exit(0)

PLAY, RECORD = "/usr/lib/rosbag/play", "/usr/lib/rosbag/record"
INPUTS = {"imu": ("imu", "/imu0"), "twist": ("twist_in", "/odometry"), "odometry": ("odometry_in", "/wheels"),
          "twist_with_covariance": ("twist_in", "/wheels")}


class Graph:
    """A ROS master of its own with some programs, all of which end with it."""

    def __init__(self, folder):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1",
                                ROS_LOG_DIR=str(folder / "log"))
        self.programs = []
        self.folder = folder
        self.start("rosmaster", "--core", "-p", str(port))
        self.master = rosgraph.Master("/node_test", self.environment["ROS_MASTER_URI"])
        self.wait("the master", self.master.is_online)

    def start(self, *command):
        with open(self.folder / f"{Path(command[0]).name}.txt", "w", encoding="utf-8") as log:
            program = subprocess.Popen(list(map(str, command)), env=self.environment, stdout=log, stderr=log)
        self.programs.append(program)
        return program

    def wait(self, what, is_there, seconds=30):
        end = time.monotonic() + seconds
        while not is_there():
            assert time.monotonic() < end, f"{what} did not come within {seconds} s"
            assert all(p.poll() in (None, 0) for p in self.programs), f"a program ended: {self.logs()}"
            time.sleep(0.1)

    def is_subscribed(self, topic):
        return any(name == topic for name, _ in self.master.getSystemState()[1])

    def logs(self):
        return "\n".join(f"{file.name}: {file.read_text()}" for file in sorted(self.folder.glob("*.txt")))

    def end(self, program):
        program.send_signal(signal.SIGINT)
        program.wait(30)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for program in reversed(self.programs):
            if program.poll() is None:
                self.end(program)


def topics_of(bag):
    with rosbag.Bag(bag) as file:
        names = {name: info.msg_type for name, info in file.get_type_and_topic_info().topics.items()}
    compressed = "/cam0/image_raw/compressed" in names
    return compressed, "/cam0/image_raw" + ("/compressed" if compressed else "")


def processor_time(program):
    """Hundredths of a second."""
    fields = Path(f"/proc/{program.pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return int(fields[11]) + int(fields[12])


def with_twists_as(kind, bag, out):
    """The bag with its twists as another type, and without the truth, which would be of the same as odometry."""
    with rosbag.Bag(bag) as source, rosbag.Bag(out, "w") as target:
        for topic, message, t in source.read_messages():
            if topic == INPUTS["twist"][1]:
                wheels = kind(header=message.header)
                wheels.twist.twist = message.twist
                if kind is Odometry:
                    wheels.pose.pose.orientation.w = 1.0
                target.write(INPUTS["odometry"][1], wheels, t)
            elif topic != "/groundtruth":
                target.write(topic, message, t)
    return out


def publish(graph, node, bag, inputs, options, out):
    """What the node publishes while the bag is played."""
    compressed, left = topics_of(bag)
    right = left.replace("cam0", "cam1")
    ending = "/compressed" if compressed else ""
    name, topic_of_inputs = INPUTS[inputs]
    program = graph.start(node, f"left/image_raw{ending}:={left}", f"right/image_raw{ending}:={right}",
                f"{name}:={topic_of_inputs}", "odometry:=/limber/odometry", f"_inputs:={inputs}",
                f"_compressed:={str(compressed).lower()}", *options)
    recorder = graph.start(RECORD, "-O", out, "/limber/odometry", "/tf", "/diagnostics")
    for topic in (left, right, topic_of_inputs, "/limber/odometry", "/diagnostics"):
        graph.wait(f"a subscriber of {topic}", lambda: graph.is_subscribed(topic))
    player = graph.start(PLAY, "--quiet", "-d", "2", bag)
    player.wait(600)
    assert player.returncode == 0, graph.logs()
    before = -1
    while processor_time(program) > before + 5:  # until the node has nothing left to do
        before = processor_time(program)
        time.sleep(3)
    graph.end(recorder)


def compare(published, run):
    columns = [line.split(",") for line in (run / "trajectory.csv").read_text().splitlines()[1:]]
    expected = {int(row[0]): [float(value) for value in row[1:8]] for row in columns}
    with rosbag.Bag(published) as bag:
        poses = [message for _, message, _ in bag.read_messages("/limber/odometry")]
        frames = [message for _, message, _ in bag.read_messages("/tf")]
        states = [status for _, array, _ in bag.read_messages("/diagnostics") for status in array.status]
    assert len(poses) > 10, f"{len(poses)} poses"
    assert len(frames) == len(poses)
    stamps = [pose.header.stamp.to_nsec() for pose in poses]
    after = [t for t in expected if t > stamps[0]]
    assert stamps[1:] == after, f"{len(stamps)} poses, limber run has {len(after)} after the first of them"
    for pose in poses[1:]:
        p, q = pose.pose.pose.position, pose.pose.pose.orientation
        px, py, pz, qw, qx, qy, qz = expected[pose.header.stamp.to_nsec()]
        assert (p.x, p.y, p.z) == (px, py, pz), f"{pose.header.stamp}: {p} is not {px, py, pz}"
        assert abs(abs(q.w * qw + q.x * qx + q.y * qy + q.z * qz) - 1) < 1e-12
        assert min(pose.pose.covariance[::7]) > 0
    names = {status.name for status in states}
    assert {"limber: navigation", "limber: calibration"} <= names, names
    print(f"{len(poses)} poses, {len(states)} diagnostics; all {len(poses) - 1} poses after the start are limber run's")


def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # or programs of a job in the background ignore it
    parser = argparse.ArgumentParser()
    for name in ("node", "limber", "bag", "calibration"):
        parser.add_argument(name)
    parser.add_argument("--imu")
    parser.add_argument("--inputs", choices=INPUTS, default="imu")
    arguments = parser.parse_args()
    imu = (["--imu", arguments.imu], [f"_imu_noise:={arguments.imu}"]) if arguments.imu else ([], [])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        bag = arguments.bag
        if arguments.inputs in ("odometry", "twist_with_covariance"):
            kind = Odometry if arguments.inputs == "odometry" else TwistWithCovarianceStamped
            bag = with_twists_as(kind, bag, folder / "wheels.bag")
        with Graph(folder) as graph:
            publish(graph, arguments.node, bag, arguments.inputs, [f"_calib:={arguments.calibration}", *imu[1]],
                    folder / "published.bag")
        command = [arguments.limber, "run", bag, "--calib", arguments.calibration, *imu[0], "--out", folder / "run"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        compare(folder / "published.bag", folder / "run")
    print("passed")


main()
