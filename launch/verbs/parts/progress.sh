# Children of a verb, what is shown while they work, and how a verb fails. Sourced; needs ROOT, BUILD, CALLER.
CHILDREN=''  # process groups that this verb started and that must not outlive it
KEEPER=''    # process that ends them if this one is killed

fail() {  # MESSAGE: one line that says what is wrong and what to do
  echo "run: $*" >&2
  exit 1
}

# Each child leads a process group of its own (setsid). A shell that is killed runs no trap, so a process of its own, the keeper,
# reads from a pipe that only this shell holds open, and ends the groups that it was told of when the pipe closes: INT, TERM after
# 8 s, KILL after 10 s. What they have started in sessions of their own (roslaunch: every node) is asked to end at the same time.
# When the shell is gone, a leader whose children have all ended is not waited for: roslaunch takes another second.
start_keeper() {
  [ -z "$KEEPER" ] || return 0
  keeper_pipe=$(mktemp -d) && mkfifo "$keeper_pipe/alive" || fail "no room for a pipe in ${TMPDIR:-/tmp}"
  # shellcheck disable=SC2016 # expanded by the keeper
  setsid sh -c '
    members() {  # PROCESS: it and all that it has started
      for child in $(cat /proc/"$1"/task/*/children 2>/dev/null); do members "$child"; done
      echo "$1"
    }
    groups="" waits=""
    while read -r word group; do
      case $word in
        add) groups="$groups $group" ;;
        end) waits=yes ;;  # the shell lives and waits for its children
        drop) kept=""; for each in $groups; do [ "$each" = "$group" ] || kept="$kept $each"; done; groups=$kept ;;
      esac
    done
    all=$(for group in $groups; do members "$group"; done)
    signal=INT waited=0  # tenths of a second
    while [ -n "$all" ] && [ "$waited" -le 100 ]; do
      left=""
      for each in $all; do  # an entry without a program has ended and waits for its parent
        [ -e /proc/"$each"/exe ] && kill "-$signal" "$each" 2>/dev/null && left="$left $each"
      done
      all=$left waited=$((waited + 1)) signal=0
      [ "$waited" != 80 ] || signal=TERM
      [ "$waited" != 100 ] || signal=KILL
      [ -z "$all" ] || sleep 0.1
      [ -n "$waits" ] || for group in $groups; do
        [ -n "$(cat /proc/"$group"/task/*/children 2>/dev/null)" ] || kill -KILL "$group" 2>/dev/null
      done
    done
    for group in $groups; do kill -KILL "-$group" 2>/dev/null; done' keeper <"$keeper_pipe/alive" >/dev/null 2>&1 &
  KEEPER=$!
  exec 9>"$keeper_pipe/alive"
  rm -r "$keeper_pipe"
}
keep() { CHILDREN="$CHILDREN $1" && echo "add $1" >&9; }  # GROUP
unkeep() { CHILDREN=${CHILDREN% "$1"} && echo "drop $1" >&9; }  # the GROUP that was kept last

stop_children() {
  trap '' INT TERM HUP QUIT  # a second signal must not interrupt this
  [ -n "$KEEPER" ] || return 0
  echo end >&9
  exec 9>&-
  # shellcheck disable=SC2086 # one word per process
  wait "$KEEPER" $CHILDREN 2>/dev/null
  KEEPER='' CHILDREN=''
}
trap stop_children EXIT
trap 'exit 130' INT
trap 'exit 131' QUIT
trap 'exit 143' TERM HUP

# The source that has been compiled for the longest in a session, as TARGET/FILE; nothing when none is.
compiled_longest() {  # SESSION
  oldest='' since=''
  for stat in /proc/[0-9]*/stat; do
    { read -r line <"$stat"; } 2>/dev/null || continue
    case $line in *'(cc1plus) '* | *'(cc1) '*) ;; *) continue ;; esac
    pid=${line%% *} rest=${line##*) }
    # shellcheck disable=SC2086 # fields 3 and on of proc(5): the session is field 6, the start field 22
    set -- "$1" $rest
    [ "$5" = "$1" ] || continue
    if [ -z "$since" ] || [ "${21}" -lt "$since" ]; then oldest=$pid since=${21}; fi
  done
  [ -n "$oldest" ] && tr '\0' '\n' 2>/dev/null <"/proc/$oldest/cmdline" | grep -m 1 -E '^[^-].*\.(c|cc|cpp|cxx)$' |
    sed "s|^$ROOT/||; s|^\.\./||; s|.*CMakeFiles/\([^/]*\)\.dir/\(Unity/\)*|\1/|; s|_cxx\.cxx\$||"
}

# Seconds until a build has made the objects of its plan, by how long each takes; nothing without a plan. Before anything is
# done the machine counts as that of build_seconds.txt.
seconds_left() {  # PLAN LOG ELAPSED
  [ -s "$1" ] || return 0
  awk -v elapsed="$3" -v cores="$(nproc)" '
    function weight(line) {
      if (line !~ /\.o$/) return 0.2
      sub(/.* /, "", line)
      sub(/.*CMakeFiles\//, "", line)
      sub(/\.dir\/(Unity\/)?/, "/", line)
      sub(/_v3\//, "/", line)
      return line in seconds ? seconds[line] : 5
    }
    FILENAME ~ /build_seconds/ { if (!/^#/) seconds[$2] = $1; next }
    FILENAME == plan { w = weight($0); total += w; squares += w * w; ++objects; next }
    !/^\[[0-9]+\/[0-9]+\] / { next }
    { done += weight($0); split($1, count, /[^0-9]+/); steps = count[3] }
    # 30 CPU seconds of the reference machine hold the pace at the start. Each core is half through its object, which is more often a
    # long one: squares / total on average.
    END {
      if (steps > objects) total += 0.2 * (steps - objects)  # generated files, links
      begun = 0.5 * cores * squares / total
      if (done + begun < total) done += begun
      left = (total - done) * (elapsed + 30 / cores) / (done + 30)
      if (left > 0) printf "%d", left
    }
  ' plan="$1" "$ROOT/launch/verbs/parts/build_seconds.txt" "$1" "$2"
}

progress_line() {  # TITLE LOG SESSION ELAPSED: how long it lasts, how long it will, what it waits for
  left=$(seconds_left "${2%.log}.plan" "$2" "$4") at=$(compiled_longest "$3")
  [ -n "$at" ] && at="compiles $at" || at=$(tail -n 1 "$2" | tr -d '\r')
  printf '%s: %d s%s: %.90s' "$1" "$4" "${left:+, about $left s left}" "$at"
}

# Shell functions share their variables: what a verb sets before it builds (scene, device, rate, seconds, record) must not
# be assigned here. Runs a command with its output in a log; says every two seconds how long it has lasted and where it is.
with_progress() {  # TITLE LOG COMMAND...
  title=$1 log=$2
  shift 2
  mkdir -p "$(dirname "$log")"
  rm -f "${log%.log}.plan"
  start_keeper
  setsid "$@" >"$log" 2>&1 </dev/null 9>&- &
  job=$!
  keep "$job"
  started=$(date +%s) shown=0
  while kill -0 "$job" 2>/dev/null; do
    sleep 0.2
    elapsed=$(($(date +%s) - started))
    if [ "$elapsed" -ge $((shown + 2)) ]; then
      shown=$elapsed
      if [ -t 2 ]; then
        printf '\r\033[K%s' "$(progress_line "$title" "$log" "$job" "$elapsed")" >&2
      elif [ $((elapsed % 30)) -lt 2 ]; then
        printf '%s\n' "$(progress_line "$title" "$log" "$job" "$elapsed")" >&2
      fi
    fi
  done
  wait "$job"
  code=$?
  unkeep "$job"
  [ -t 2 ] && [ "$shown" -gt 0 ] && printf '\r\033[K' >&2
  [ "$shown" -gt 0 ] && echo "$title: $(($(date +%s) - started)) s" >&2
  return "$code"
}

with_progress_or_log() {  # TITLE LOG COMMAND...: ends this script with the end of the log when the command fails
  with_progress "$@" && return
  code=$?
  tail -n 40 "$2" >&2
  fail "$1 failed (exit code $code); all of its output is in $2"
}
