# SPDX-License-Identifier: MIT
"""Bags that limber writes, read by ROS 1's own rosbag. Usage: rosbag_test.py LIMBER FIXTURES"""
import io
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import diagnostic_msgs.msg  # noqa: F401: rosbag finds the messages' classes by name
    import nav_msgs.msg  # noqa: F401
    import roslib.message
    import rosbag
    import sensor_msgs.msg  # noqa: F401
    import tf2_msgs.msg  # noqa: F401
except ImportError as missing:
    print(f"skipped: needs Debian's python3-rosbag, python3-sensor-msgs, python3-nav-msgs, "
          f"python3-tf2-msgs, python3-diagnostic-msgs: {missing}")
    sys.exit(0)

LIMBER, FIXTURES = sys.argv[1], Path(sys.argv[2])
CALIBRATION = ["--calib", str(FIXTURES / "camchain.yaml"), "--imu", str(FIXTURES / "imu.yaml")]


def convert(source, out, *more):
    command = [LIMBER, "convert", str(source), "--out", str(out), *more]
    result = subprocess.run(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    assert result.returncode == 0, f"{command}: {result.stderr}"
    return out


def check_messages(path):
    """Every message is what its type's own class makes of it, byte by byte."""
    seen = {}
    with rosbag.Bag(path) as bag:
        for topic, (name, data, md5, _, dynamic), _ in bag.read_messages(raw=True):
            installed = roslib.message.get_message_class(name)
            assert installed is not None, f"no package of {name}"
            for kind in (installed, dynamic):  # of ROS, and made of the definition in the bag
                assert kind._md5sum == md5, f"{topic}: md5 of {name} is {kind._md5sum}, not {md5}"
                again = io.BytesIO()
                kind().deserialize(data).serialize(again)
                assert again.getvalue() == data, f"{topic}: another {name} comes back"
            seen[topic] = seen.get(topic, 0) + 1
    return seen


def by_stamp(path, topic, fields):
    with rosbag.Bag(path) as bag:
        messages = [message for _, message, _ in bag.read_messages(topics=[topic])]
    assert messages, f"{path}: nothing on {topic}"
    return [(m.header.stamp, *(getattr(m, field) for field in fields)) for m in messages]


def check_recording(folder):
    original = FIXTURES / "ros1_none.bag"
    sizes = set()
    for compression in ("none", "bz2", "lz4"):
        path = convert(original, folder / f"{compression}.bag", *CALIBRATION, "--compression", compression)
        seen = check_messages(path)
        assert seen["/imu0"] == 41 and seen["/cam0/image_raw"] == 5, seen
        for topic, fields in {
            "/imu0": ("angular_velocity", "linear_acceleration"),
            "/cam0/image_raw": ("height", "width", "encoding", "step", "data"),
            "/cam1/image_raw": ("data",),
        }.items():
            assert by_stamp(path, topic, fields) == by_stamp(original, topic, fields), f"{path} {topic}"
        with rosbag.Bag(path) as bag:
            assert bag.get_compression_info().compression == compression
            assert bag.get_message_count() == sum(seen.values())  # by the index
        subprocess.run(["rosbag", "info", str(path)], check=True, stdout=subprocess.DEVNULL)
        sizes.add(path.stat().st_size)
    assert len(sizes) == 3, "each compression has its own size"


def check_results(folder):
    """Results of a run of three seconds."""
    scenario = folder / "scenario.yaml"
    scenario.write_text("duration: 3\nworld: {points: 60}\n")
    for command in (["simulate", scenario, "--out", folder / "log"],
                    ["run", folder / "log", "--init", "groundtruth", "--out", folder / "run"]):
        subprocess.run([LIMBER, *map(str, command)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    path = convert(folder / "run", folder / "run.bag")
    seen = check_messages(path)
    lines = (folder / "run/trajectory.tum").read_text().splitlines()
    poses = [list(map(float, line.split())) for line in lines if not line.startswith("#")]
    assert seen["/tf"] == seen["/limber/odometry"] == len(poses), seen
    with rosbag.Bag(path) as bag:
        for (_, odometry, _), (_, tf, _), pose in zip(bag.read_messages("/limber/odometry"), bag.read_messages("/tf"), poses):
            p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
            assert abs(odometry.header.stamp.to_sec() - pose[0]) < 1e-6
            assert all(abs(a - b) < 1e-9 for a, b in zip((p.x, p.y, p.z, q.x, q.y, q.z, q.w), pose[1:]))
            assert tf.transforms[0].transform.translation.x == p.x and tf.transforms[0].child_frame_id == "body"
            assert odometry.pose.covariance[0] > 0 and odometry.pose.covariance[35] > 0
        levels = [status.level for _, array, _ in bag.read_messages("/diagnostics") for status in array.status]
        assert set(levels) <= {0, 1, 2, 3} and len(levels) >= len(poses)
        latched = {c.topic for c in bag._get_connections() if c.header.get("latching") in ("1", b"1")}
        assert latched == {"/limber/path", "/groundtruth/path", "/limber/map"}, latched


with tempfile.TemporaryDirectory() as name:
    check_recording(Path(name))
    check_results(Path(name))
print("passed")
