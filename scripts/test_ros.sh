#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the ROS 1 node of ros/ against limber as the release preset has built it, and plays a bag to it. Not part of
# scripts/test.sh: says "skipped" where ROS 1 is not installed.
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(libroscpp-dev libsensor-msgs-dev libgeometry-msgs-dev libnav-msgs-dev libtf2-msgs-dev libdiagnostic-msgs-dev python3-rosbag
          python3-rosmaster python3-nav-msgs python3-tf2-msgs python3-diagnostic-msgs)
missing=()
for package in "${packages[@]}"; do
  [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null)" == installed ]] || missing+=("$package")
done
if ((${#missing[@]} > 0)); then
  echo "skipped: needs ROS 1: apt-get install --no-install-recommends ${missing[*]}"
  exit 0
fi
if [[ ! -x build/release/limber ]]; then
  echo "build/release/limber is not built: cmake --preset release && cmake --build --preset release" >&2
  exit 1
fi

work=build/ros
rm -rf "$work/prefix"
cmake --install build/release --prefix "$work/prefix" --component development >/dev/null
cmake -S ros -B "$work" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$PWD/$work/prefix" >/dev/null
cmake --build "$work" -j2

"$work/core_test"
rm -rf "$work/data"
mkdir "$work/data"
# Long enough: limber run starts by the middle of a recording, the node cannot know where that is.
sed 's/^duration:.*/duration: 20/' scenarios/drone_none.yaml >"$work/data/room.yaml"
{ cat "$work/data/room.yaml"; echo "use_imu: false"; echo "odometry: {rate: 50}"; } >"$work/data/wheels.yaml"
for recording in room wheels; do
  build/release/limber simulate "$work/data/$recording.yaml" --images --out "$work/data/$recording"
  build/release/limber convert "$work/data/$recording" --out "$work/data/$recording.bag" --pixels raw
done
for test in "room imu" "wheels twist" "wheels odometry" "wheels twist_with_covariance"; do
  read -r recording inputs <<<"$test"
  /usr/bin/python3 ros/test/node_test.py "$work/limber_node" build/release/limber "$work/data/$recording.bag" \
    "$work/data/$recording" --inputs "$inputs"
done
rm -rf "$work/data"
