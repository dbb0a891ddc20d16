# SPDX-License-Identifier: MIT
# bash completion for limber: asks the program itself, so that it is never out of date.
_limber() {
  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} program=${COMP_WORDS[0]}
  local methods="ekf ekf-full lcekf soft consider adaptive mono-left oracle"
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" --help 2>/dev/null |
      sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\+\).*/\1/p') --help --version" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" "$command" --help 2>/dev/null |
      grep -oE -- '(^|[ ,])--[a-z-]+' | tr -d ' ,' | sort -u)" -- "$word")
  elif [[ ${COMP_WORDS[COMP_CWORD - 1]} == --method ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$methods" -- "$word")
  elif [[ ${COMP_WORDS[COMP_CWORD - 1]} == --methods ]]; then
    local named=""
    [[ $word == *,* ]] && named=${word%,*},
    mapfile -t COMPREPLY < <(compgen -P "$named" -W "$methods" -- "${word##*,}")
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -o filenames -F _limber limber
