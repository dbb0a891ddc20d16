#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds, and tests: everything in Release for this machine's processor, then the filter's mathematics
# and what reads foreign bytes again under the address and undefined behaviour sanitizers. That build names no processor: it is the
# portable one (x86-64 without AVX and FMA), so that no numerical test rests on one processor's rounding. There the tests'
# own sources are watched by the address sanitizer alone, which halves the time that they compile.
# Leaves the program at build/release/limber.
#
#   scripts/test.sh [--full]
#
# --full, before a release or a large change: the long tests (label `full`: all runs of statistics of which there are a few
# else, pages in space and on a phone, whole recordings, what compiles limber anew for its users), the sanitizers in every
# room, the benchmarks built, and all of it compiled by GCC, as packages are.
set -euo pipefail

usage="usage: scripts/test.sh [--full]"
full=false
case "${1:-}" in
  "") ;;
  --full) full=true ;;
  -h | --help) echo "$usage"; exit 0 ;;
  *) echo "$usage" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
trap 'echo "limber: FAILED, see above" >&2' ERR

# The folders of tests/ that the sanitizers watch every time: the filter's rooms but for its start, and what reads recordings
# and calibrations. Nothing of it needs the start.
filter="core;sensors;predict;measure;state;landmarks;stack;update;health;navigate"
watched="$filter;evaluate;io;clean;rig_files;images;datasets;bags;simulate"
released=(--label-exclude '^full$')
lines=(-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1)  # reports name functions, and with --full lines, too: a tenth of the compiler's time
if $full; then
  lines=()
  filter+=";initialize"
  watched=""
  released=()
fi

echo "== Release"
scripts/build.sh
if $full; then
  cmake --build --preset release --target benchmarks
fi
ctest --preset release "${released[@]}"

# The users' projects (label `consumer`), the browser (`page`), the documented commands (`docs`) and the long statistics
# (`slow`) were run above.
echo "== Sanitizers"
cmake --preset asan -DLIMBER_FILTER_ROOMS="$filter" -DLIMBER_TEST_ROOMS="$watched" "${lines[@]}" >/dev/null
cmake --build --preset asan --target test_programs
ctest --preset asan --label-exclude 'slow|consumer|page|docs'

if $full; then
  echo "== GCC"
  cmake --preset gcc >/dev/null
  cmake --build --preset gcc
  echo "limber: every test passed, in Release and under the sanitizers"
else
  echo "limber: the tests passed, in Release and under the sanitizers (scripts/test.sh --full: all there are)"
fi
