# What the words of a user stand for: numbers, paths, scenes, devices, recordings. Sourced.

is_number() {  # TEXT: a plain decimal number > 0
  case $1 in '' | . | *[!0-9.]* | *.*.*) return 1 ;; esac
  [ -n "$(printf %s "$1" | tr -d '0.')" ]
}

absolute() {  # PATH, relative to where the user stands
  case $1 in /*) echo "$1" ;; *) echo "$CALLER/$1" ;; esac
}

# Prints the file that a scene's or device's name stands for; large scenes have a folder of their own.
find_description() {  # KIND NAME FOLDER SUFFIX...
  local found_kind found_name found_folder found_plain found_suffix found_each found_known
  found_kind=$1 found_name=$2 found_folder=$3
  shift 3
  case $found_name in
    */* | *.urdf | *.xacro | *.yaml)
      [ -f "$(absolute "$found_name")" ] || fail "$found_kind '$found_name': no such file"
      ensure_description "$found_kind" "$found_name"
      absolute "$found_name"
      return ;;
  esac
  found_plain=$(printf %s "$found_name" | tr 'A-Z-' 'a-z_')
  for found_suffix; do
    for found_each in "$found_name" "$found_plain" "spidar_$found_plain" "large/$found_plain"; do
      [ -f "$found_folder/$found_each.$found_suffix" ] && echo "$ROOT/$found_folder/$found_each.$found_suffix" && return
    done
  done
  found_known=$(for found_suffix; do
    find "$found_folder" -maxdepth 1 -name "*.$found_suffix" -printf '%f\n' 2>/dev/null
  done | sed 's/\.[a-z]*$//' | sort -u | tr '\n' ' ')
  fail "unknown $found_kind '$found_name'; give a path, or one of: $found_known"
}
# A file that says what it describes, and does not break off: all else is read by programs that are not built yet.
ensure_description() {  # KIND PATH
  local described_file described_mark
  described_file=$(absolute "$2")
  [ -r "$described_file" ] || fail "$1 '$2' cannot be read by $(id -un)"
  case $1 in
    scene) described_mark='<robot or models:' ;;
    device) described_mark='strings:' ;;
    study) described_mark='study:' ;;
  esac
  if grep -aq '<robot' "$described_file" && [ "$1" = scene ]; then
    [ "$(tail -c 4096 "$described_file" | tr -d ' \t\r\n\0' | tail -c 1)" = '>' ] || fail "scene '$2' breaks off: its last tag is not closed"
  else
    grep -aq "${described_mark##* }" "$described_file" || fail "$1 '$2' is none: it has no $described_mark"
  fi
}
find_scene() { find_description scene "$1" urdf/scenes yaml urdf; }  # NAME_OR_PATH
find_device() { find_description device "$1" urdf/devices yaml; }    # NAME_OR_PATH
find_study() { find_description study "$1" urdf/experiments yaml; }  # NAME_OR_PATH

is_device() {  # NAME_OR_PATH
  case $1 in
    *.urdf) return 1 ;;
    */* | *.yaml) grep -qs '^strings:' "$(absolute "$1")" ;;
    *) ! (find_scene "$1") >/dev/null 2>&1 && (find_device "$1") >/dev/null 2>&1 ;;
  esac
}

study_device() {  # FILE: the name of its device
  local study_named
  study_named=$(sed -n 's/^device: *\([^ #]*\).*/\1/p' "$1" | head -n 1)
  echo "${study_named:-spidar_g6x3r}"
}

is_study() {  # NAME_OR_PATH
  case $1 in
    */* | *.yaml) grep -qs '^study:' "$(absolute "$1")" ;;
    *) [ -f "urdf/experiments/$1.yaml" ] ;;
  esac
}

# A study's session: its folder sub-ID/ses-N.
is_session() { [ -f "$(absolute "$1")/session.json" ]; }  # PATH

# The recording of one trial.
trial_bag() {  # SESSION NUMBER
  local trial_file
  case $2 in '' | *[!0-9]*) fail "--trial '$2' is no number of a trial" ;; esac
  trial_file=$(absolute "$1")/trials/trial-$(printf %03d "${2#"${2%%[!0]*}"}").bag
  [ -f "$trial_file" ] || fail "$1 has no recording of trial $2: it was interrupted, or there is no such trial"
  echo "$trial_file"
}

# A recording, a bag or an MCAP file: by its ending, or by how the file begins.
is_recording() {  # PATH
  case $1 in
    *.bag | *.mcap) return 0 ;;
    *) [ -f "$(absolute "$1")" ] && case $(head -c 7 "$(absolute "$1")" | tr -d '\0') in '#ROSBAG' | ?MCAP0?) true ;; *) false ;; esac ;;
  esac
}
# A file that is there and begins as a recording does.
ensure_recording() {  # VERB PATH
  [ ! -d "$(absolute "$2")" ] || fail "$1: '$2' is a folder: give a bag or MCAP file"
  [ -f "$(absolute "$2")" ] || fail "$1: '$2': no such file"
  case $(head -c 7 "$(absolute "$2")" | tr -d '\0') in
    '#ROSBAG' | ?MCAP0?) ;;
    *) fail "$1: '$2' is no recording: give a bag or MCAP file that ./run demo --record has written" ;;
  esac
}
is_mcap() { [ -f "$1" ] && [ "$(head -c 6 "$1" | tail -c 5 | tr -d '\0')" = MCAP0 ]; }  # PATH

free_port() {
  python3 -c 'import socket
with socket.socket() as s:
    s.bind(("127.0.0.1", 0))
    print(s.getsockname()[1])'
}

# A port of this machine at which a master can listen. Before set-up there may be no python3, and its number alone is judged.
ensure_master_port() {  # NUMBER
  local master_problem
  { [ ${#1} -le 5 ] && [ "$1" -ge 1024 ] && [ "$1" -le 65535 ]; } || fail "demo: --master-port $1: a master wants a port of 1024 to 65535"
  command -v python3 >/dev/null || return 0
  master_problem=$(python3 -c 'import socket, sys
port = int(sys.argv[1])
with socket.socket() as s:
    s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        s.bind(("", port))
    except OSError as error:
        sys.exit(print(f"{error.strerror}: stop the master that is there, or take another port") or 1)' "$1") ||
    fail "demo: --master-port $1: $master_problem"
}
