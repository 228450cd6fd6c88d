# Children of a verb, what is shown while they work, and how a verb fails. Sourced; needs ROOT, BUILD, CALLER.
CHILDREN=''  # process groups that this verb started and that must not outlive it

fail() {  # MESSAGE: one line that says what is wrong and what to do
  echo "run: $*" >&2
  exit 1
}

# Each child leads a process group of its own (setsid), so that nothing it started outlives it.
stop_children() {
  trap '' INT TERM HUP  # a second signal must not interrupt this
  for pid in $CHILDREN; do kill -INT "-$pid" 2>/dev/null; done
  for pid in $CHILDREN; do
    waited=0  # quarters of a second
    while kill -0 "-$pid" 2>/dev/null && [ "$waited" -lt 40 ]; do
      [ "$waited" = 32 ] && kill -TERM "-$pid" 2>/dev/null
      sleep 0.25
      waited=$((waited + 1))
    done
    kill -KILL "-$pid" 2>/dev/null
    wait "$pid" 2>/dev/null
  done
  CHILDREN=''
}
trap stop_children EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

# Shell functions share their variables: what a verb sets before it builds (scene, device, rate, seconds, record) must not
# be assigned here. Runs a command with its output in a log; says every two seconds how long it has lasted and where it is.
with_progress() {  # TITLE LOG COMMAND...
  title=$1 log=$2
  shift 2
  mkdir -p "$(dirname "$log")"
  setsid "$@" >"$log" 2>&1 </dev/null &
  job=$!
  CHILDREN="$CHILDREN $job"
  started=$(date +%s) shown=0
  while kill -0 "$job" 2>/dev/null; do
    sleep 0.2
    elapsed=$(($(date +%s) - started))
    if [ "$elapsed" -ge $((shown + 2)) ]; then
      shown=$elapsed
      if [ -t 2 ]; then
        printf '\r\033[K%s: %d s: %.90s' "$title" "$elapsed" "$(tail -n 1 "$log" | tr -d '\r')" >&2
      elif [ $((elapsed % 30)) -lt 2 ]; then
        printf '%s: %d s: %.90s\n' "$title" "$elapsed" "$(tail -n 1 "$log" | tr -d '\r')" >&2
      fi
    fi
  done
  wait "$job"
  code=$?
  CHILDREN=${CHILDREN% "$job"}
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
