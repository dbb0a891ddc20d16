#!/bin/sh
# SPDX-License-Identifier: MIT
# man_pages.sh LIMBER VERSION FOLDER: limber.1 and a page for each command, made of --help.
set -eu
limber=$1 version=$2 folder=$3
mkdir -p "$folder"
page() {  # NAME TITLE HELP
  help2man --no-info --section=1 --manual="User Commands" --source="limber $version" --version-string="limber $version" \
    --name="$2" --help-option="$3" "$limber" | sed "1s/LIMBER/$(echo "$1" | tr a-z A-Z)/; s/^limber \\\\- /$1 \\\\- /" |
    gzip -9n >"$folder/$1.1.gz"
}
page limber "stereo navigation for rigs that bend" --help
"$limber" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\+\)  *\(.*\)/\1 \2/p' | while read -r command title; do
  page "limber-$command" "$title" "$command --help"
done
