# Lines `figure NAME VALUE UNIT` of programs: shown, and kept with where they were measured. Sourced.

machine() {
  printf '%s, %s cores, %s' "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)" "$(nproc)" "$(uname -sr)"
}

commit() {
  git -c safe.directory='*' describe --always --dirty 2>/dev/null || echo unknown
}

# Prints the figure lines of a log and appends them to a CSV, each with where it was measured.
keep_figures() {  # CSV LOG FLAGS [FOLDER]
  local kept_before kept_rows kept_csv
  kept_csv=${4:-$FIGURES}/$1.csv
  mkdir -p "${4:-$FIGURES}"
  [ -f "$kept_csv" ] || echo 'name,value,unit,machine,commit,compiler,flags' >"$kept_csv"
  kept_before=$(wc -l <"$kept_csv")
  awk -v where="\"$(machine)\",$(commit),\"$(g++ --version | head -n 1)\",\"$3\"" -v csv="$kept_csv" '
    $1 == "figure" && NF >= 3 {
      print
      unit = $4
      for (i = 5; i <= NF; ++i) unit = unit " " $i
      printf "%s,%s,\"%s\",%s\n", $2, $3, unit, where >>csv
    }' "$2"
  kept_rows=$(($(wc -l <"$kept_csv") - kept_before))
  [ "$kept_rows" = "$(awk '$1 == "figure" && NF >= 3' "$2" | wc -l)" ] || fail "$kept_csv cannot be written: is the disk full?"
}

# Shows what a program says, and keeps its figures. It stands where the user does. Until it has ended, its output is in a
# folder of this call: another call of the same verb has its own.
show_and_keep() {  # NAME COMMAND...
  local shown_name shown_own shown_code
  shown_name=$1
  shift
  mkdir -p "$FIGURES" "$LOGS"
  shown_own=$(mktemp -d "$LOGS/$shown_name.XXXXXX") || fail "no folder can be made in $LOGS"
  (cd "$CALLER" && exec "$@") >"$shown_own/$shown_name.log"
  shown_code=$?
  grep -v '^figure ' "$shown_own/$shown_name.log"
  (keep_figures "$shown_name" "$shown_own/$shown_name.log" '-O3 -DNDEBUG -ffp-contract=off' "$shown_own") || shown_code=1
  if ! { mv -f "$shown_own/$shown_name.csv" "$FIGURES/$shown_name.csv" && mv -f "$shown_own/$shown_name.log" "$LOGS/$shown_name.log" &&
    rmdir "$shown_own"; }; then
    fail "$FIGURES or $LOGS cannot be written"
  fi
  return "$shown_code"
}
