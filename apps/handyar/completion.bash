# SPDX-License-Identifier: MIT
# Completion for bash: it offers what --help says, and files.
_handyar() {
  local program=${COMP_WORDS[0]} command=${COMP_WORDS[1]}
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} offered
  if ((COMP_CWORD == 1)); then
    offered="--help --version $("$program" --help 2>/dev/null |
      sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')"
  elif [[ $word == -* ]]; then
    offered=$("$program" "$command" --help 2>/dev/null |
      sed -n 's/^  \(-h,\)*\(--[a-z-]*\).*/\2/p')
  elif [[ $before == --* ]]; then  # of an option like "--method figure|paper (figure)" its choices
    offered=$("$program" "$command" --help 2>/dev/null |
      sed -n "s/^  $before \([a-z_|]*|[a-z_|]*\) .*/\1/p" | tr '|' ' ')
  fi
  mapfile -t COMPREPLY < <(compgen -W "$offered" -- "$word")
}
complete -o default -F _handyar handyar
