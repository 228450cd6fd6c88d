# Output whose reader ends first (head, less): a relay reads on, so that the verb and its programs end their work. Sourced.

RELAYS=''  # processes, of which each ends with its last writer

# Each of fd 1 and 2 that is a pipe becomes a pipe to a relay, one for both where they are the same: lines keep their order.
relay_output() {
  local relay_folder
  { [ -p /dev/fd/1 ] || [ -p /dev/fd/2 ]; } && relay_folder=$(mktemp -d 2>/dev/null) || return 0
  if [ -p /dev/fd/1 ] && [ "$(readlink "/proc/$$/fd/1")" = "$(readlink "/proc/$$/fd/2")" ]; then
    start_relay "$relay_folder/both" && exec >"$relay_folder/both" 2>&1
  else
    [ ! -p /dev/fd/1 ] || { start_relay "$relay_folder/out" && exec >"$relay_folder/out"; }
    [ ! -p /dev/fd/2 ] || { start_relay "$relay_folder/err" >&2 && exec 2>"$relay_folder/err"; }
  fi
  rm -r "$relay_folder"
}

start_relay() {  # FIFO: to what is fd 1 now
  mkfifo "$1" || return 1
  # shellcheck disable=SC2094 # another process writes
  (trap '' INT QUIT TERM HUP; cat || exec cat >/dev/null) <"$1" 2>/dev/null &
  RELAYS="$RELAYS $!"
}

# A verb ends when all that it said has been told: the first process of a container takes all others with it.
end_relays() {
  exec >/dev/null 2>&1
  # shellcheck disable=SC2086 # one word per process
  [ -z "$RELAYS" ] || wait $RELAYS
}

relay_output
