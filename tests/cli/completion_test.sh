#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# completion_test.sh LIMBER COMPLETION: what Tab offers.
set -euo pipefail
source "$2"
offers() {  # WORDS...: completes the last one
  COMP_WORDS=("$program" "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _limber
  echo " ${COMPREPLY[*]} "
}
program=$1
[[ "$(offers "")" == *" run "*" study "* ]]
[[ "$(offers si)" == " simulate " ]]
[[ "$(offers run --sig)" == " --sigma-px " ]]
[[ "$(offers run --method lc)" == " lcekf " ]]
[[ "$(offers run --methods ekf,ad)" == " ekf,adaptive " ]]
[[ "$(offers comp)" == " compare " ]]
[[ "$(offers health "$(dirname "$2")/limber.ba")" == *limber.bash* ]]
