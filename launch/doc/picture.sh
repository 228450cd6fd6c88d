#!/bin/sh
# Takes the pictures of the documentation from the running demo, on a display of its own:
#   launch/doc/picture.sh PICTURE.png [SECOND [DEMO_ARGUMENTS]]     (default: after 4 s of `./run demo --rviz`)
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
set -eu
[ $# -ge 1 ] || { echo "usage: $0 PICTURE.png [SECOND [DEMO_ARGUMENTS]]" >&2; exit 2; }
case $1 in /*) picture=$1 ;; *) picture=$(pwd -P)/$1 ;; esac
second=${2:-4}
[ $# -lt 2 ] || shift
shift
cd "$(dirname "$0")/../.."
./run build

temporary=$(mktemp -d)
demo='' server=''
finish() {
  [ -z "$demo" ] || { kill -TERM "$demo" 2>/dev/null && wait "$demo"; } || true
  [ -z "$server" ] || kill "$server" 2>/dev/null || true
  rm -rf "$temporary"
}
trap finish EXIT
trap 'exit 130' INT TERM

Xvfb -displayfd 3 -screen 0 1440x860x24 +extension GLX -nolisten tcp 3>"$temporary/display" 2>/dev/null &
server=$!
waited=0
while ! [ -s "$temporary/display" ]; do
  [ "$waited" -lt 50 ] || { echo "picture: Xvfb did not start" >&2; exit 1; }
  sleep 0.1
  waited=$((waited + 1))
done
DISPLAY=:$(cat "$temporary/display")
export DISPLAY LIBGL_ALWAYS_SOFTWARE=1 QT_X11_NO_MITSHM=1 XDG_RUNTIME_DIR="$temporary"

./run demo --rviz --seconds 600 "$@" >"$temporary/demo.log" 2>&1 &
demo=$!
# rviz has drawn its scene when the picture is no longer one plain colour.
waited=0
until import -window root "$temporary/shot.png" 2>/dev/null &&
    [ "$(identify -format %k "$temporary/shot.png")" -gt 500 ]; do
  kill -0 "$demo" 2>/dev/null || { cat "$temporary/demo.log" >&2; exit 1; }
  [ "$waited" -lt 60 ] || { echo "picture: rviz drew nothing in 60 s" >&2; exit 1; }
  sleep 1
  waited=$((waited + 1))
done
sleep "$second"
import -window root "$temporary/shot.png"
# The view without rviz's own panels.
convert "$temporary/shot.png" -crop 1056x764+366+63 +repage -resize 900x -strip -colors 224 "PNG8:$picture"
echo "picture: $picture ($(($(wc -c <"$picture") / 1024)) kB)"
