#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fails and names the lines if a tracked C++ file is not formatted as .clang-format says (--fix formats them), or a library prints.
set -euo pipefail
cd "$(dirname "$0")/.."

action=(--dry-run -Werror)
if [[ "${1:-}" == --fix ]]; then
  action=(-i)
fi
git ls-files -z -- '*.hpp' '*.cpp' | xargs -0 clang-format --style=file "${action[@]}"

# A library never prints, and listens to no variable of the environment but those that start studies.
if git grep -nE '\b(fprintf|printf|puts)\(|std::(cout|cerr|clog)\b|\bgetenv\(' -- src include ':!src/study/launcher.cpp'; then
  echo "check_format.sh: see above: a library never prints" >&2
  exit 1
fi
