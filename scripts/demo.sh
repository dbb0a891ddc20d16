#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a fresh clone to an answer: installs what is missing, builds limber, simulates the paper's sound rig (i) and the one
# that is bent by shocks (iv), six runs each, navigates each with five methods from an automatic start, and prints how each
# fared. The page beside the table opens on the same answer.
#
#   scripts/demo.sh [OUTPUT_FOLDER]       default: results/demo
# Called again it goes on with the study that is there, and prints and draws the same.
set -euo pipefail

usage="usage: scripts/demo.sh [OUTPUT_FOLDER]"
case "${1:-}" in
  -h | --help) echo "$usage"; exit 0 ;;
  -*) echo "$usage" >&2; exit 2 ;;
esac
results=$(realpath --canonicalize-missing -- "${1:-$(dirname "$0")/../results/demo}")
cd "$(dirname "$0")/.."
mkdir -p "$results"

# LIMBER_PROGRAM and LIMBER_DEMO_RUNS are for the test of this script.
limber=${LIMBER_PROGRAM:-}
if [[ -z "$limber" ]]; then
  limber=$PWD/build/release/limber
  echo "Building build/release/limber (the first time takes some minutes)"
  scripts/build.sh limber
fi

runs=${LIMBER_DEMO_RUNS:-6}
echo "Simulating and navigating: 2 rigs x $runs runs x 5 methods, 35 s of flight each"
log=$results/study.log
if ! "$limber" study scenarios/paper_i.yaml scenarios/paper_iv.yaml --methods ekf,ekf-full,lcekf,adaptive,mono-left \
  --runs "$runs" --seed 1 --init auto --brief --out "$results/study.sqlite" >"$results/table.md" 2> >(tee "$log" >&2); then
  echo "demo: the study failed; all it said is in $log" >&2
  exit 1
fi
echo
cat "$results/table.md"
cat <<TEXT

paper_i: the rig is as calibrated. paper_iv: shocks at 10, 20 and 27 s move the right camera by up to 0.1 deg and 10 cm (baseline: 2 m).
The same with figures, in any browser: $results/study.html
Next: $limber run --help
TEXT
