#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Remakes the README's figures, docs/images/position-*.svg: mean squared position error of ekf, ekf-full and lcekf over
# 10 runs of the paper's cases (ii) and (iv). Needs build/release/limber, node and chromium; some minutes.
set -euo pipefail
cd "$(dirname "$0")/.."

results=results/readme
mkdir -p "$results" docs/images
build/release/limber study scenarios/paper_ii.yaml scenarios/paper_iv.yaml --init groundtruth --methods ekf,ekf-full,lcekf --runs 10 \
  --seed 1 --out "$results/study.sqlite"
for case in ii iv; do
  scripts/export_figure.mjs "$results/study.html" "case-paper-$case-position" "docs/images/position-$case.svg" \
    --log --size 620x400
done
