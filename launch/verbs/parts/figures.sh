# Lines `figure NAME VALUE UNIT` of programs: shown, and kept with where they were measured. Sourced.

machine() {
  printf '%s, %s cores, %s' "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)" "$(nproc)" "$(uname -sr)"
}

commit() {
  git -c safe.directory='*' describe --always --dirty 2>/dev/null || echo unknown
}

# Prints the figure lines of a log and appends them to a CSV, each with where it was measured.
keep_figures() {  # CSV LOG FLAGS
  mkdir -p "$FIGURES"
  [ -f "$FIGURES/$1.csv" ] || echo 'name,value,unit,machine,commit,compiler,flags' >"$FIGURES/$1.csv"
  rows_before=$(wc -l <"$FIGURES/$1.csv")
  awk -v where="\"$(machine)\",$(commit),\"$(g++ --version | head -n 1)\",\"$3\"" -v csv="$FIGURES/$1.csv" '
    $1 == "figure" && NF >= 3 {
      print
      unit = $4
      for (i = 5; i <= NF; ++i) unit = unit " " $i
      printf "%s,%s,\"%s\",%s\n", $2, $3, unit, where >>csv
    }' "$2"
  rows=$(($(wc -l <"$FIGURES/$1.csv") - rows_before))
  [ "$rows" = "$(awk '$1 == "figure" && NF >= 3' "$2" | wc -l)" ] || fail "$FIGURES/$1.csv cannot be written: is the disk full?"
}

# Shows what a program says, and keeps its figures. It stands where the user does. Until it has ended, its output is in a
# folder of this call: another call of the same verb has its own.
show_and_keep() {  # NAME COMMAND...
  name=$1
  shift
  mkdir -p "$FIGURES" "$LOGS"
  own=$(mktemp -d "$LOGS/$name.XXXXXX") || fail "no folder can be made in $LOGS"
  (cd "$CALLER" && exec "$@") >"$own/$name.log"
  code=$?
  grep -v '^figure ' "$own/$name.log"
  (FIGURES=$own && keep_figures "$name" "$own/$name.log" '-O3 -DNDEBUG -ffp-contract=off') || code=1
  mv -f "$own/$name.csv" "$FIGURES/$name.csv" && mv -f "$own/$name.log" "$LOGS/$name.log" && rmdir "$own" || fail "$FIGURES or $LOGS cannot be written"
  return "$code"
}
