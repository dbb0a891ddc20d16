#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what limber is built from and is not there yet (Debian 12 packages). Says nothing when all is there.
#
#   scripts/install_dependencies.sh [--filter | --packaging | --check]
#
# --filter     no more than limber::filter is built from, and scripts/check_format.sh needs
# --packaging  what scripts/package.sh and scripts/test_packages.sh need, too
# --check      installs nothing; fails if something is missing
set -euo pipefail

usage="usage: scripts/install_dependencies.sh [--filter | --packaging | --check]"
what=${1:-}
case "$what" in
  "" | --filter | --packaging | --check) ;;
  -h | --help) echo "$usage"; exit 0 ;;
  *) echo "$usage" >&2; exit 2 ;;
esac

filter=(
  g++ cmake ninja-build ccache
  clang libclang-rt-14-dev lld    # compiles the presets `release` and `asan`; GCC the other ones, and users' projects
  libeigen3-dev
  clang-format python3            # scripts/
)
rest=(
  libceres-dev  # the smoother
  libyaml-cpp-dev libfmt-dev nlohmann-json3-dev libcli11-dev  # datasets, simulator, program
  libopencv-dev libpng-dev libspng-dev libtiff-dev libturbojpeg0-dev libdeflate-dev  # image front end
  libbz2-dev liblz4-dev libzstd-dev zlib1g-dev  # bags
  libcpp-httplib-dev              # the live view
  libsqlitecpp-dev libtbb-dev libopenmpi-dev openmpi-bin  # studies
  nodejs npm chromium             # the page of reports, and a browser to test it
  libgtest-dev libgmock-dev libbenchmark-dev  # tests and benchmarks
  doxygen libjs-mathjax           # the docs site
  pybind11-dev python3-dev python3-numpy python3-matplotlib python3-pytest  # the Python module
  help2man dpkg-dev file          # manual pages and Debian packages
  python3-pip python3-setuptools python3-wheel python3-venv python3-build   # its wheel
)
packaging=(lintian debootstrap)

case "$what" in
  --filter) packages=("${filter[@]}") ;;
  --packaging) packages=("${filter[@]}" "${rest[@]}" "${packaging[@]}") ;;
  *) packages=("${filter[@]}" "${rest[@]}") ;;
esac

# npm may have come with another nodejs than Debian's, which the Debian package would not go with.
is_installed() {
  [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" == installed ]] ||
    { [[ "$1" == npm || "$1" == nodejs ]] && command -v "${1/nodejs/node}" >/dev/null; }
}

missing=()
for package in "${packages[@]}"; do
  is_installed "$package" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  exit 0
elif [[ "$what" == --check ]]; then
  exit 1
fi

if ! command -v apt-get >/dev/null; then
  echo "limber needs these Debian 12 packages, or what your system calls them: ${missing[*]}" >&2
  exit 1
fi
as_root=(env DEBIAN_FRONTEND=noninteractive)
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "Neither root nor sudo: ask your administrator for 'apt-get install ${missing[*]}'" >&2
    exit 1
  fi
  as_root=(sudo "${as_root[@]}")
fi

echo "Installing ${#missing[@]} Debian packages: ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${as_root[@]}" apt-get update && 
       "${as_root[@]}" apt-get install --yes --no-install-recommends "${missing[@]}"; } >"$log" 2>&1 </dev/null; then
  tail -n 30 "$log" >&2
  echo "apt-get failed, see above" >&2
  exit 1
fi
