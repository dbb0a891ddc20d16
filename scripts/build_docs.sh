#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the docs site: user pages, derivations, evidence and the API of include/limber, with equations drawn by a MathJax that
# lies beside the pages (no network). Fails where a public name of a header is undocumented, a type's members among them,
# and on anything else that Doxygen warns of.
#
#   scripts/build_docs.sh [OUTPUT_FOLDER]       default: results/docs; the site begins at html/index.html
set -euo pipefail

out=$(realpath --canonicalize-missing -- "${1:-$(dirname "$0")/../results/docs}")
cd "$(dirname "$0")/.."
mathjax=/usr/share/javascript/mathjax
if ! command -v doxygen >/dev/null || [[ ! -d $mathjax ]]; then
  echo "build_docs: needs Debian's doxygen and libjs-mathjax" >&2
  exit 1
fi
mkdir -p "$out"
[[ -f $out/html/doxygen.css ]] && rm -r "$out/html" # pages of an older tree

# What Doxygen's filter shows of each header, made at once: an interpreter for each takes ten times as long as the rest.
filtered=$(mktemp -d)
trap 'rm -r "$filtered"' EXIT
python3 docs/shared_comments.py include "$filtered/include"
printf '#!/bin/sh\nexec cat "%s/${1#"%s"/}"\n' "$filtered" "$PWD" >"$filtered/show"
chmod +x "$filtered/show"
{
  cat docs/Doxyfile
  echo "OUTPUT_DIRECTORY = \"$out\""
  echo "FILTER_PATTERNS = *.hpp=\"$filtered/show\""
} | doxygen - >"$out/doxygen.log" 2>"$out/warnings.log"
if grep -E 'warning:|error:' "$out/warnings.log" >&2; then
  echo "build_docs: the names above need a comment, or the pages above mending" >&2
  exit 1
fi

# Fonts as pictures are for browsers of the last century, and most of the weight.
mkdir -p "$out/html/mathjax"
tar --create --dereference --directory "$mathjax" --exclude=fonts/HTML-CSS/TeX/png --exclude=localization . |
  tar --extract --directory "$out/html/mathjax"

# What pages link to beside pages: examples lie beside them, folders are the list of pages.
cp -r examples "$out/html/"
sed -i -E 's#href="\.\./examples/#href="examples/#g; s#href="(docs/)?(evidence|derivations)"#href="pages.html"#g' "$out"/html/*.html
python3 docs/heading_links.py "$out/html"
python3 tests/docs/site_links.py "$out/html"
echo "$out/html/index.html"
