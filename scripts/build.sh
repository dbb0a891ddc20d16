#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing and builds build/release. On a new machine the filter, which needs Eigen alone, is compiled while
# the other packages are installed: that keeps one core busy for two minutes.
#
#   scripts/build.sh [TARGET]       default: everything
set -euo pipefail
cd "$(dirname "$0")/.."
target=${1:-all}

all_but_filter=()
switch() {  # <ON or OFF>
  all_but_filter=()
  for option in BUILD_DATASETS BUILD_SMOOTH BUILD_FRONTEND BUILD_TESTS BUILD_EXAMPLES BUILD_BENCHMARKS WITH_REPORT; do
    all_but_filter+=("-DLIMBER_$option=$1")
  done
}

if ! scripts/install_dependencies.sh --check; then
  scripts/install_dependencies.sh --filter
  scripts/install_dependencies.sh &
  installing=$!
  switch OFF
  cmake --preset release "${all_but_filter[@]}" >/dev/null
  cmake --build --preset release --target limber_filter
  wait "$installing"
  switch ON
fi
cmake --preset release "${all_but_filter[@]}" >/dev/null
cmake --build --preset release --target "$target"
