#!/bin/sh
# SPDX-License-Identifier: MIT
# man_pages.sh PROGRAM VERSION DIR: a manual page of the program and one of each of its subcommands,
# made of what --help says, so that they cannot differ.
set -eu
program=$1 version=$2 dir=$3
mkdir -p "$dir"

# page NAME: the page of the help that is read.
page() {
  awk -v name="$1" -v version="$version" '
    function escaped(text) {
      gsub(/\\/, "\\e", text); gsub(/-/, "\\-", text)
      return text ~ /^[.\x27]/ ? "\\&" text : text
    }
    function section(title) { print ".SH " toupper(title); verbatim = title == "Examples" }
    NR == 1 {
      gsub(/\.$/, "")
      print ".TH " toupper(name) " 1 \"\" \"handyar " version "\" \"User Commands\""
      section("Name"); print escaped(name " - " $0)
      next
    }
    sub(/^Usage: /, "") { section("Synopsis"); print escaped($0); next }
    /^[A-Z][a-z]+:$/ { sub(/:$/, ""); section($0); if (verbatim) print ".nf"; listed = 1; next }
    sub(/^Exit codes: /, "") { section("Exit status"); listed = 0 }
    /^$/ { if (verbatim) print ".fi"; verbatim = 0; blank = 1; next }
    verbatim { print escaped($0); next }
    listed && /^  [^ ]/ {  # an option or subcommand, and what it does
      sub(/^  /, "")
      at = match($0, /  +/)
      print ".TP"; print ".B " escaped(at ? substr($0, 1, RSTART - 1) : $0)
      if (at) print escaped(substr($0, RSTART + RLENGTH))
      blank = 0
      next
    }
    {
      if (listed && !/^ /) { section("Description"); listed = 0 }
      else if (blank) print ".PP"
      blank = 0
      sub(/^ +/, ""); print escaped($0)
    }' | gzip -9n > "$dir/$1.1.gz"
}

"$program" --help | page handyar
for command in $("$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
  "$program" "$command" --help | page "handyar-$command"
done
