# What every program of launch/verbs starts with: folders, the other parts, --help, --version. Sourced.
# Another python3 ahead of /usr/bin (pyenv, conda) breaks catkin and every ROS script: the path is fixed first.
CALLER_PATH=${PATH:-}
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
# What programs print is read here: words and numbers are not those of the user's language.
export LC_ALL=C.UTF-8
set -u
CALLER=$(pwd -P)  # paths that the user gives are relative to it
PROGRAM=$(readlink -f "$0")
cd "$(dirname "$PROGRAM")/../.." || exit 1
ROOT=$(pwd -P)
BUILD=$ROOT/build
LOGS=$BUILD/log
FIGURES=$BUILD/figures
SETUP_BUILDS=''  # targets that a verb builds after its set-up, which says what both cost
for part in output progress packages first_cost build figures names options emulator wasm; do
  # shellcheck disable=SC1090 # parts of this folder
  . "$ROOT/launch/verbs/parts/$part.sh"
done
trap 'stop_children; end_relays' EXIT
for part; do
  case $part in
    -h | --help)
      echo 'usage: ./run'
      sed -n 's/^#: \{0,1\}/  /p' "$PROGRAM"
      exit 0 ;;
    --version) [ "$(basename "$PROGRAM")" = version.sh ] || { "$ROOT/launch/verbs/version.sh"; exit; } ;;
  esac
done
