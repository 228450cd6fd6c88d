# The cost of a first call, said before it begins: packages, megabytes (10^6 bytes) to fetch and to write, minutes. Sourced.

# Seconds that a piece of work takes on each core of this machine as busy as it is, over those of the machine of build_seconds.txt: the
# third of nine, for something else often takes a core for a moment. (gzip is one program on both releases; the arithmetic of Debian
# 13's mawk takes .6 of the time of Debian 12's.)
slowness() {
  local slowness_round slowness_began slowness_each
  for slowness_round in 1 2 3 4 5 6 7 8 9; do
    slowness_began=$(date +%s%N)
    for slowness_each in $(seq "$(nproc)"); do
      seq 200000 | gzip -9 >/dev/null &
    done
    wait
    echo "$((($(date +%s%N) - slowness_began) / 1000000))"
  done | sort -n | awk -v reference="$SLOWNESS_REFERENCE_MS" 'NR == 3 { printf "%.2f", $1 / reference }'
}
SLOWNESS_REFERENCE_MS=130

# CPU seconds of the reference machine, and megabytes, of a first build of these targets. `all` has the core twice
# (HAPTIC_X86_64_V3), `tests` has their programs as well.
build_cost() {  # TARGETS
  awk -v targets=" $1 " '
    /^#/ || $2 ~ /_v3\// { next }
    $3 == "later" { later += $1; next }
    { demo += $1; if ($2 ~ /^haptic_core\//) core += $1 }
    END {
      seconds = demo; megabytes = 50
      if (targets ~ / all /) { seconds += core + later; megabytes += 130 }
      if (targets ~ / tests /) { seconds += 560; megabytes += 500 }
      if (targets ~ /^ *$/) seconds = megabytes = 0
      print seconds, megabytes
    }' "$ROOT/launch/verbs/parts/build_seconds.txt"
}

# Prints the line; ends the verb where the disk is too small.
first_cost() {  # APT PACKAGE...
  local cost_apt cost_plan cost_cost cost_free
  cost_apt=$1
  shift
  # (--assume-no would install where no other package comes along: apt has no question then.)
  cost_plan=$("$cost_apt" -c "$APT_CONF" install --print-uris --fix-broken --no-remove --no-install-recommends "$@" 2>/dev/null)
  cost_free=$(df -Pk "$BUILD" | awk 'NR == 2 { printf "%d", $4 * 1024 / 1e6 }')
  cost_cost=$(printf '%s\n' "$cost_plan" | awk -v build="$(build_cost "${SETUP_BUILDS:-}")" -v slow="$(slowness)" -v cores="$(nproc)" \
    -v fetched="$(sed -n 's/^Fetched \(.*\) in .* (\(.*\))$/\2/p' "$LOGS/packages.log" | tail -n 1)" '
    function megabytes(number, unit) { gsub(/,/, "", number); return number * (unit ~ /^G/ ? 1000 : unit ~ /^M/ ? 1 : unit ~ /^k/ ? 0.001 : 1e-6) }
    / newly installed/ { count = $3 + $1 }
    /^Need to get/ { line = $4; unit = $5; sub(/\/.*/, "", unit); fetch = megabytes(line, unit) }
    /^After this operation.* additional/ { unpacked = megabytes($4, $5) }
    # (dpkg: seconds for each package and each megabyte that it unpacks, of set-ups of both releases on the reference machine.)
    END {
      split(build, b, " "); split(fetched, f, " "); rate = megabytes(f[1], f[2])
      if (rate < 0.5) rate = 0.5
      written = 1.15 * unpacked + b[2]
      seconds = fetch / rate / 2 + slow * (0.12 * count + 0.045 * unpacked) + slow * b[1] / cores
      printf "%d %.0f %.0f %.0f", count, fetch, written, seconds
    }')
  # shellcheck disable=SC2086 # four numbers
  set -- $cost_cost
  [ "$3" -lt "$cost_free" ] ||
    fail "the disk of $BUILD is too small: $3 MB are to be written, $cost_free MB are free; make room and call again"
  echo "installs $1 Debian packages: $2 MB to fetch, with the build about $3 MB to write ($cost_free MB are free) in about $(minutes "$4")"
}

minutes() {  # SECONDS
  if [ "$1" -lt 60 ]; then echo "$(($1 / 10 + 1))0 s"; else echo "$(((${1%.*} + 30) / 60)) min"; fi
}
