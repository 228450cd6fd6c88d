# Output whose reader ends first (head, less): a relay reads on, so that the verb and its programs end their work. Sourced.

RELAYS=''  # processes, of which each ends with its last writer

# Each of fd 1 and 2 that is a pipe becomes a pipe to a relay, one for both where they are the same: lines keep their order.
relay_output() {
  local relay_folder
  { [ -p /dev/fd/1 ] || [ -p /dev/fd/2 ]; } && relay_folder=$(mktemp -d 2>/dev/null) || return 0
  if [ -p /dev/fd/1 ] && [ "$(readlink "/proc/$$/fd/1")" = "$(readlink "/proc/$$/fd/2")" ]; then
    start_relay "$relay_folder/both" && exec >&9 2>&1 9>&-
  else
    [ ! -p /dev/fd/1 ] || { start_relay "$relay_folder/out" && exec >&9 9>&-; }
    [ ! -p /dev/fd/2 ] || { start_relay "$relay_folder/err" >&2 && exec 2>&9 9>&-; }
  fi
  rm -r "$relay_folder"
}

# The FIFO is opened for reading and writing first, so that neither end waits for the other: a signal that interrupted an open that
# waits would leave a relay that waits for ever.
start_relay() {  # FIFO: to what is fd 1 now; fd 9 is its writer
  # shellcheck disable=SC2094 # a FIFO: what one end writes the other reads
  mkfifo "$1" && exec 7<>"$1" 8<"$1" 9>"$1" 7<&- || return 1
  (trap '' INT QUIT TERM HUP; cat || exec cat >/dev/null) <&8 2>/dev/null 8<&- 9>&- &
  RELAYS="$RELAYS $!"
  exec 8<&-
}

# A verb ends when all that it said has been told: the first process of a container takes all others with it.
end_relays() {
  exec >/dev/null 2>&1
  # shellcheck disable=SC2086 # one word per process
  [ -z "$RELAYS" ] || wait $RELAYS
}

relay_output
