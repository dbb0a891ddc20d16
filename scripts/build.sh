#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing and builds build/release. On a new machine the filter, which needs Eigen alone, is compiled while
# the other packages are installed: that keeps one core busy for two minutes.
#
#   scripts/build.sh [TARGET]       default: everything
set -euo pipefail
cd "$(dirname "$0")/.."
target=${1:-all}

configure() {  # <ON or OFF: all but the filter>
  local options=()
  for part in BUILD_DATASETS BUILD_SMOOTH BUILD_FRONTEND BUILD_TESTS BUILD_EXAMPLES BUILD_BENCHMARKS WITH_REPORT; do
    options+=("-DLIMBER_$part=$1")
  done
  cmake --preset release "${options[@]}" >/dev/null
}

if ! scripts/install_dependencies.sh --check; then
  scripts/install_dependencies.sh --filter
  scripts/install_dependencies.sh &
  installing=$!
  configure OFF
  cmake --build --preset release --target limber_filter
  wait "$installing"
fi
configure ON
cmake --build --preset release --target "$target"
