#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# scripts/test_packages.sh [FOLDER [ROOT]]: installs the packages of scripts/package.sh (FOLDER, default: build/package) into a Debian of
# nothing but its base system (ROOT, default: build/package-root, made by debootstrap where it is not there), tries program, Python
# module and library there, and removes them again. Needs root and a Debian mirror; not part of scripts/test.sh.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-build/package}
root=${2:-build/package-root}
scripts/install_dependencies.sh --packaging
if [[ ! -x $root/bin/sh ]]; then
  debootstrap --variant=minbase bookworm "$root" "${LIMBER_MIRROR:-http://deb.debian.org/debian}" >/dev/null
fi
rm -rf "$root/tmp/limber"
mkdir -p "$root/tmp/limber"
cp "$folder"/*.deb "$root/tmp/limber"
cp -r tests/consumer/find_package tests/consumer/filter_step.cpp tests/bags/fixtures/ros1_lz4.bag "$root/tmp/limber"
cp /etc/resolv.conf "$root/etc"
cat >"$root/tmp/limber/try.sh" <<'TRY'
set -euo pipefail
cd /tmp/limber
export DEBIAN_FRONTEND=noninteractive LC_ALL=C
install() { apt-get install -qq --no-install-recommends "$@" >>install.log 2>&1 || { tail -5 install.log; exit 1; }; }
apt-get update -qq
install ./limber_*.deb
limber --version
limber info ros1_lz4.bag | head -1
printf 'duration: 6\n' >short.yaml
limber simulate short.yaml --seed 1 --out DATASET
limber run DATASET --out DIR 2>/dev/null | head -1
if limber run DATASET --out DIR 2>said; then exit 1; fi
cat said
limber simulate short.yaml --seed 1 --images --out PICTURES | tail -1
test -s DIR/report.html
test -s /usr/share/man/man1/limber.1.gz
install ./python3-limber_*.deb
python3 -c "import limber; print('python3-limber:', limber.run(limber.read('DATASET')).summary['ate_m']['se3'])"
install ./liblimber-dev_*.deb g++ cmake make
cmake -S find_package -B consumer >/dev/null
cmake --build consumer >/dev/null
echo "liblimber-dev: $(./consumer/consumer | head -1)"
apt-get purge -qq limber python3-limber liblimber-dev >>install.log 2>&1
if left=$(find /usr /etc /var/lib/dpkg/info -iname '*limber*' | grep .); then
  echo "left behind: $left"
  exit 1
fi
echo "removed, nothing left behind"
TRY
unshare --mount --propagation private bash -c '
  mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" bash /tmp/limber/try.sh' "$root"
