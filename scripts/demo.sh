#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a fresh clone to a table: installs what is missing, builds limber, simulates the paper's cases (ii) and (iv)
# with IMU, navigates them with five methods and prints how each fared.
#
#   scripts/demo.sh [OUTPUT_FOLDER]       default: results/demo
set -euo pipefail

cases=(paper_ii paper_iv)
methods=(ekf ekf-full lcekf oracle mono-left)
seed=1

usage="usage: scripts/demo.sh [OUTPUT_FOLDER]"
case "${1:-}" in
  -h | --help) echo "$usage"; exit 0 ;;
  -*) echo "$usage" >&2; exit 2 ;;
esac
start=$PWD
results=$(realpath --canonicalize-missing -- "${1:-$(dirname "$0")/../results/demo}")
cd "$(dirname "$0")/.."
limber=$PWD/build/release/limber
mkdir -p "$results/logs"

# run_logged NAME COMMAND...: silent unless it fails; then its last lines, and where the rest is.
run_logged() {
  local log=$results/logs/$1.log
  if ! "${@:2}" >"$log" 2>&1; then
    { tail -n 20 "$log"; echo "demo: '${*:2}' failed; all it said is in $log"; } >&2
    return 1
  fi
}

simulate() {
  run_logged "$1.simulate" "$limber" simulate "scenarios/$1.yaml" --out "$results/$1/recording" --seed "$seed"
  echo "  simulated $1"
}

navigate() {
  run_logged "$1.$2" "$limber" run "$results/$1/recording" --method "$2" --out "$results/$1/$2" --init groundtruth
  echo "  ran $2 on $1"
}

# in_parallel FUNCTION: calls it with each line of the input as arguments, two at a time; fails if any call did.
in_parallel() {
  xargs -P 2 -L 1 bash -euo pipefail -c "$1"' "$@"' "$1"
}
export limber results seed
export -f run_logged simulate navigate

scripts/install_dependencies.sh
echo "Building build/release/limber (the first time takes some minutes)"
cmake --preset release >/dev/null
cmake --build --preset release --target limber

echo "Simulating cases (ii) and (iv) of the paper, 35 s each"
printf '%s\n' "${cases[@]}" | in_parallel simulate
echo "Navigating"
for case in "${cases[@]}"; do
  printf "$case %s\n" "${methods[@]}"
done | in_parallel navigate

summaries=()
for case in "${cases[@]}"; do
  for method in "${methods[@]}"; do
    summaries+=("$results/$case/$method/summary.json")
  done
done
echo
table=$PWD/scripts/print_summary_table.py
(cd "$start" && python3 "$table" "${summaries[@]}")
echo
echo "Each folder holds trajectory.tum, trajectory.csv, landmarks.ply, summary.json and report.html, which any browser opens."
echo "Next: $limber run --help"
