#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# scripts/package.sh [FOLDER]: builds limber for any x86-64 and packs limber, liblimber-dev and python3-limber (Debian) into
# FOLDER (default: build/package); what lintian calls an error or a warning in them is a failure.
# LIMBER_ARCH=x86-64-v3 (or as -march= takes it) in the environment: for such processors alone.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-build/package}
scripts/install_dependencies.sh --packaging
cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr -DLIMBER_BUILD_TESTS=OFF \
  -DLIMBER_BUILD_EXAMPLES=OFF -DLIMBER_ARCH="${LIMBER_ARCH:-}" >/dev/null
cmake --build "$folder"
(cd "$folder" && cpack -G DEB)
lintian --allow-root --fail-on error,warning "$folder"/*.deb
