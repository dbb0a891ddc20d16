#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fails and names the lines if a tracked C++ file is not formatted as .clang-format says. --fix formats them.
set -euo pipefail
cd "$(dirname "$0")/.."

action=(--dry-run -Werror)
if [[ "${1:-}" == --fix ]]; then
  action=(-i)
fi
git ls-files -z -- '*.hpp' '*.cpp' | xargs -0 clang-format --style=file "${action[@]}"
