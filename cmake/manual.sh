#!/usr/bin/env bash
# manual.sh PROGRAM PAGE BASH ZSH: writes the man page and the completions of bash and zsh, from the program's own help.
set -euo pipefail
program=$1 page=$2 bash=$3 zsh=$4
help() { COLUMNS=$1 "$program" "${@:2}" --help; }
roff() { sed 's/\\/\\e/g; s/-/\\-/g; s/^\([.'\'']\)/\\\&\1/'; }
fixed() { printf '.nf\n'; roff; printf '.fi\n'; }

mapfile -t commands < <(help 5000 | sed -nE '/^Subcommands:/,/^$/s/^  ([a-z]+) .*/\1/p')
[ ${#commands[@]} -gt 0 ] || { echo "manual.sh: $program --help lists no command" >&2; exit 1; }
{
  printf '.TH LCPBENCH 1 "" "%s"\n.SH NAME\nlcpbench \\- compares LCP and contact solvers\n' "$("$program" --version)"
  printf '.SH SYNOPSIS\n.B lcpbench\n.I COMMAND\n[options]\n.SH DESCRIPTION\n'
  help 72 | fixed
  for command in "${commands[@]}"; do
    printf '.SH "LCPBENCH %s"\n' "${command^^}"
    help 72 "$command" | fixed
  done
} > "$page"

# Lines COMMAND, OPTION, its kind of value, its choices, what it does; and for each command one without an option. What
# an option does begins in a column of its own, on the next line where the option is long.
describe() {
  for command in "${commands[@]}"; do
    help 5000 "$command" | awk -v command="$command" -v OFS='\t' '
      function put() { if (option != "") print command, option, kind, choices, text; option = "" }
      NR == 1 { print command, "", "", "", $0 }
      /^  -/ {
        put()
        match($0, /--[a-z0-9-]+/)
        option = substr($0, RSTART, RLENGTH)
        rest = substr($0, RSTART + RLENGTH)
        kind = match(rest, /^ (TEXT|FLOAT|INT|UINT)/) ? substr(rest, 2, RLENGTH - 1) : ""
        choices = match(rest, /:[{][^}]*[}]/) ? substr(rest, RSTART + 2, RLENGTH - 3) : ""
        gsub(/,/, " ", choices)
        text = substr($0, 29, 2) == "  " ? substr($0, 31) : ""
        next
      }
      option != "" && text == "" && /^   / { sub(/^ +/, ""); text = $0 }
      /^$/ { put() }
      END { put() }'
  done
}

describe | awk -F '\t' '
  { option[$1] = option[$1] " " $2; if ($2 == "") names = names " " $1 }
  $4 != "" { choices = choices "    " $1 ":" $2 ") words=\"" $4 "\" ;;\n" }
  END {
    print "# bash completion for lcpbench"
    print "_lcpbench() {\n  local current=${COMP_WORDS[COMP_CWORD]} words="
    print "  case ${COMP_WORDS[1]}:${COMP_WORDS[COMP_CWORD - 1]} in\n" choices "    *) [ \"${current:0:1}\" != - ] ||"
    print "      case ${COMP_WORDS[1]} in"
    for (each in option) print "        " each ") words=\"" option[each] "\" ;;"
    print "      esac ;;\n  esac\n  [ \"$COMP_CWORD\" -gt 1 ] || words=\"" names "\""
    print "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n}"
    print "complete -o default -F _lcpbench lcpbench"
  }' > "$bash"

describe | awk -F '\t' -v quote="'" '
  function quoted(text) { gsub(quote, quote "\\" quote quote, text); return quote text quote }
  {
    text = $5
    gsub(/\[|\]|:|\\/, "\\\\&", text)
    value = $3 == "" ? "" : ":" tolower($3) ":"
    value = $4 != "" ? ":value:(" $4 ")" : $3 == "TEXT" ? value "_files" : value
    if ($2 == "") commands = commands "    " quoted($1 ":" text) "\n"
    else options[$1] = options[$1] " \\\n        " quoted("*" $2 "[" text "]" value)
  }
  END {
    print "#compdef lcpbench\n_lcpbench() {\n  local -a commands=(\n" commands "  )"
    print "  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n  local command=$words[2]"
    print "  shift words\n  (( CURRENT-- ))\n  case $command in"
    for (each in options) print "    " each ") _arguments" options[each] " \\\n        \"*:file:_files\" ;;"
    print "  esac\n}\n_lcpbench \"$@\""
  }' > "$zsh"
