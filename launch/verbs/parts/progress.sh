# Children of a verb, what is shown while they work, and how a verb fails. Sourced; needs ROOT, BUILD, CALLER.
CHILDREN=''  # process groups that this verb started and that must not outlive it
KEEPER=''    # process that ends them if this one is killed
GENTLE=''    # the child that must not be stopped in the middle of its step, if one runs

fail() {  # MESSAGE: one line that says what is wrong and what to do
  echo "run: $*" >&2
  exit 1
}

# Each child leads a process group of its own (setsid). A shell that is killed runs no trap, so a process of its own, the keeper,
# reads from a pipe that only this shell holds open, and ends the groups that it was told of when the pipe closes: INT, TERM after
# 8 s, KILL after 10 s. What they have started in sessions of their own (roslaunch: every node) is asked to end at the same time.
# When the shell is gone, a leader whose children have all ended is not waited for: roslaunch takes another second.
# A group that was told `gently` is one that must not stand still in the middle: of apt the leader alone gets INT, which it obeys
# when dpkg has finished its step, and it is waited for.
start_keeper() {
  local keeper_pipe
  [ -z "$KEEPER" ] || return 0
  if ! { keeper_pipe=$(mktemp -d) && mkfifo "$keeper_pipe/alive"; }; then fail "no room for a pipe in ${TMPDIR:-/tmp}"; fi
  # Both ends are opened here, the first one for reading as well, so that neither open waits for the other end: a signal that
  # interrupted one that waits would leave a keeper that waits for ever, and a shell that waits for the keeper.
  exec 9<>"$keeper_pipe/alive" 8<"$keeper_pipe/alive"
  rm -r "$keeper_pipe"
  # shellcheck disable=SC2016 # expanded by the keeper
  setsid sh -c '
    members() {  # PROCESS: it and all that it has started
      for child in $(cat /proc/"$1"/task/*/children 2>/dev/null); do members "$child"; done
      echo "$1"
    }
    without() {  # GROUP GROUPS
      for each in $2; do [ "$each" = "$1" ] || echo "$each"; done
    }
    groups="" gentle="" waits=""
    while read -r word group; do
      case $word in
        add) groups="$groups $group" ;;
        gently) gentle="$gentle $group" ;;
        end) waits=yes ;;  # the shell lives and waits for its children
        drop) groups=$(without "$group" "$groups") gentle=$(without "$group" "$gentle") ;;
      esac
    done
    for group in $gentle; do kill -INT "$group" 2>/dev/null; done
    waited=0  # tenths of a second; an hour is far beyond any step of dpkg
    for group in $gentle; do
      while [ -e /proc/"$group"/exe ] && [ "$waited" -lt 36000 ]; do sleep 0.1; waited=$((waited + 1)); done
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
    for group in $groups; do kill -KILL "-$group" 2>/dev/null; done' keeper <&8 >/dev/null 2>&1 8<&- 9>&- &
  KEEPER=$!
  exec 8<&-
}
keep() { CHILDREN="$CHILDREN $1" && echo "${2:-add} $1" >&9; }  # GROUP [gently]
unkeep() { CHILDREN=${CHILDREN% "$1"} && echo "drop $1" >&9; }  # the GROUP that was kept last

stop_children() {
  trap '' INT TERM HUP QUIT  # a second signal must not interrupt this
  [ -n "$KEEPER" ] || return 0
  [ -z "$GENTLE" ] || echo "setup: interrupted; lets dpkg finish its step, which the next call goes on from" >&2
  echo end >&9
  exec 9>&-
  # shellcheck disable=SC2086 # one word per process
  wait "$KEEPER" $CHILDREN 2>/dev/null
  KEEPER='' CHILDREN=''
}
trap stop_children EXIT

# A signal between the start of a child and its note would leave it behind: it is held until both are done.
HELD=''  # exit code of a signal that came meanwhile
hold_signals() {
  trap 'HELD=130' INT
  trap 'HELD=131' QUIT
  trap 'HELD=143' TERM HUP
}
let_signals() {
  trap 'exit 130' INT
  trap 'exit 131' QUIT
  trap 'exit 143' TERM HUP
  [ -z "$HELD" ] || exit "$HELD"
}
let_signals

# The compilers that run in a session: seconds of CPU time of all, and of the one that has run for the longest its source, as
# TARGET/FILE; nothing when none runs.
compiling() {  # SESSION
  local compiling_session compiling_stat compiling_line compiling_pid compiling_rest compiling_oldest compiling_since compiling_ticks
  compiling_session=$1 compiling_oldest='' compiling_since='' compiling_ticks=0
  for compiling_stat in /proc/[0-9]*/stat; do
    { read -r compiling_line <"$compiling_stat"; } 2>/dev/null || continue
    case $compiling_line in *'(cc1plus) '* | *'(cc1) '*) ;; *) continue ;; esac
    compiling_pid=${compiling_line%% *} compiling_rest=${compiling_line##*) }
    # shellcheck disable=SC2086 # fields 3 and on of proc(5): the session is field 6, the times 14 and 15, the start 22
    set -- $compiling_rest
    [ "$4" = "$compiling_session" ] || continue
    compiling_ticks=$((compiling_ticks + ${12} + ${13}))
    if [ -z "$compiling_since" ] || [ "${20}" -lt "$compiling_since" ]; then compiling_oldest=$compiling_pid compiling_since=${20}; fi
  done
  [ -n "$compiling_oldest" ] || return 0
  printf '%s ' "$((compiling_ticks / 100))"  # 100 ticks a second on every Linux that Debian builds
  tr '\0' '\n' 2>/dev/null <"/proc/$compiling_oldest/cmdline" | grep -m 1 -E '^[^-].*\.(c|cc|cpp|cxx)$' |
    sed "s|^$ROOT/||; s|^\.\./||; s|.*CMakeFiles/\([^/]*\)\.dir/\(Unity/\)*|\1/|; s|_cxx\.cxx\$||"
}

# Seconds until a build has made the objects of its plan, by how long each takes beside the others; nothing without a plan, and
# nothing before a tenth is done, since until then the pace of this machine is not known. A compiler that runs counts as far as
# its CPU time goes, at the pace of those that have ended.
seconds_left() {  # PLAN LOG ELAPSED RUNNING_CPU_SECONDS
  [ -s "$1" ] || return 0
  awk -v elapsed="$3" -v running="${4:-0}" -v cores="$(nproc)" '
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
    END {
      if (steps > objects) total += 0.2 * (steps - objects)  # generated files, links
      # Each core is half through its object, which is more often a long one: squares / total on average. The CPU time of the
      # compilers tells more once the machine is known, from what they and those before have taken of elapsed * cores.
      begun = 0.5 * cores * squares / total
      spent = elapsed * cores - running
      if (running > 0 && done > 0 && spent > 0) begun = running * done / spent
      if (done + begun < total) done += begun
      if (done >= 0.1 * total && (left = (total - done) * elapsed / done) > 0) printf "%d", left
    }
  ' plan="$1" "$ROOT/launch/verbs/parts/build_seconds.txt" "$1" "$2"
}

# The log's last line where it says how far its program is: of ninja, ctest and apt. Anything else there is not meant for this place.
step_of() {  # LOG
  tail -n 1 "$1" | tr -d '\r' | grep -E '^(\[[0-9]+/[0-9]+\] |[ 0-9]+/[0-9]+ Test |(Get:|Unpacking|Setting up|Preparing to unpack) ?)' |
    sed 's/^\(.\{90\}\).*/\1/'
}

progress_line() {  # TITLE LOG SESSION ELAPSED: how long it lasts, how long it will, what it waits for
  local line_running line_left line_at
  line_running=$(compiling "$3")
  line_left=$(seconds_left "${2%.log}.plan" "$2" "$4" "${line_running%% *}")
  line_at=${line_running#* }
  if [ -n "$line_running" ]; then line_at="compiles $line_at"; else line_at=$(step_of "$2"); fi
  printf '%s: %d s%s%s' "$1" "$4" "${line_left:+, about $line_left s left}" "${line_at:+: $line_at}"
}

# Runs a command with its output in a log; says every two seconds how long it has lasted and where it is. With INTERRUPT=gently it
# is one that must not be stopped in the middle of its step.
with_progress() {  # TITLE LOG COMMAND...
  local progress_title progress_log progress_job progress_started progress_shown progress_elapsed progress_code
  progress_title=$1 progress_log=$2
  shift 2
  mkdir -p "$(dirname "$progress_log")"
  rm -f "${progress_log%.log}.plan"
  : >"$progress_log" || fail "$progress_log cannot be written by $(id -un)"
  hold_signals
  start_keeper
  # A shell without job control has what it starts aside ignore INT, which would wait for TERM then.
  setsid env --default-signal=INT,QUIT "$@" >"$progress_log" 2>&1 </dev/null 9>&- &
  progress_job=$!
  [ "${INTERRUPT:-}" != gently ] || GENTLE=$progress_job
  keep "$progress_job" "${INTERRUPT:-add}"
  let_signals
  progress_started=$(date +%s) progress_shown=0
  while kill -0 "$progress_job" 2>/dev/null; do
    sleep 0.2
    progress_elapsed=$(($(date +%s) - progress_started))
    if [ "$progress_elapsed" -ge $((progress_shown + 2)) ]; then
      progress_shown=$progress_elapsed
      if [ -t 2 ]; then
        printf '\r\033[K%s' "$(progress_line "$progress_title" "$progress_log" "$progress_job" "$progress_elapsed")" >&2
      elif [ $((progress_elapsed % 30)) -lt 2 ]; then
        printf '%s\n' "$(progress_line "$progress_title" "$progress_log" "$progress_job" "$progress_elapsed")" >&2
      fi
    fi
  done
  wait "$progress_job"
  progress_code=$?
  unkeep "$progress_job"
  GENTLE=''
  [ -t 2 ] && [ "$progress_shown" -gt 0 ] && printf '\r\033[K' >&2
  [ "$progress_shown" -gt 0 ] && echo "$progress_title: $(($(date +%s) - progress_started)) s" >&2
  return "$progress_code"
}

with_progress_or_log() {  # TITLE LOG COMMAND...: ends this script with the end of the log when the command fails
  local or_log_code
  with_progress "$@" && return
  or_log_code=$?
  tail -n 40 "$2" >&2
  fail "$1 failed (exit code $or_log_code); all of its output is in $2"
}
