#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds and runs every test: Release for this machine's processor, then again under the
# address and undefined behaviour sanitizers (without the long statistics). The sanitizer build names no processor: it
# is the portable one (x86-64 without AVX and FMA), so that no numerical test rests on one processor's rounding. There
# the tests' own sources are watched by the address sanitizer alone, which halves the time that they compile.
# Leaves the program at build/release/limber.
set -euo pipefail
cd "$(dirname "$0")/.."
trap 'echo "limber: FAILED, see above" >&2' ERR

scripts/install_dependencies.sh

build() {
  echo "== Building with preset $1"
  cmake --preset "$1" >/dev/null
  cmake --build --preset "$1"
}

build release
ctest --preset release

# The users' projects (label `consumer`), the browser (`page`), the documented commands (`docs`) and the long statistics
# (`slow`) were run above.
build asan
ctest --preset asan --label-exclude 'slow|consumer|page|docs'

echo "limber: every test passed, in Release and under the sanitizers"
