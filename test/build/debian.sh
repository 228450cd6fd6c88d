#!/bin/sh
# Tries this commit in a bare Debian, as on a machine that has nothing yet:
#
#   test/build/debian.sh bookworm|trixie [CALL...]
#
#   test/build/debian.sh trixie                          ./run setup, ./run demo, ./run test
#   test/build/debian.sh bookworm setup 'test core_'     each CALL: a verb of ./run with its arguments
#   test/build/debian.sh trixie 'shell ls -l build/log'  a command in the checkout there
#
# The system and the checkout, with what was built, stay in build/debian/RELEASE for the next call (4 to 6 GB; rm -rf takes them away).
# The checkout is brought to this one's last commit each time; what is not committed is not in it. Only `setup` has a network, the
# other calls have loopback alone. Needs root, git, debootstrap and iproute2 (./run setup test). Nothing of it stays mounted or running.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd -P)
say() { echo "debian.sh: $*" >&2; }
# shellcheck disable=SC1091 # beside this script
. "$root/test/build/bare.sh"
release=${1:-}
case $release in '' | -* | *[!a-z]*) say 'usage: test/build/debian.sh bookworm|trixie [CALL...]'; exit 2 ;; esac
in_own_namespaces "$@"
shift
[ $# -gt 0 ] || set -- setup demo test

bare=$root/build/debian/$release
make_bare "$bare" "$release" "$root/build/log/debian-$release.log"
mount_bare "$bare"
there=$bare/haptics
[ -d "$there/.git" ] || git init -q "$there"
git -C "$there" fetch -q --depth 1 "file://$root" HEAD
git -C "$there" checkout -q --force --detach FETCH_HEAD
git -C "$there" clean -fdq
# shellcheck disable=SC1091 # of the bare system
say "$release: $(. "$bare/etc/os-release" && echo "$PRETTY_NAME"), commit $(git -C "$there" describe --always)"
[ -z "$(git -C "$root" status --porcelain --untracked-files=no)" ] || say 'changes that are not committed are left out'

run_call() {  # CALL
  reach=alone
  case $1 in
    'shell '*) enter alone "$bare" sh -c "cd /haptics && ${1#shell }"; return ;;
    setup | 'setup '*) reach=network ;;
  esac
  set -f  # a call is words, and a regular expression no pattern for files
  # shellcheck disable=SC2016,SC2086
  enter "$reach" "$bare" sh -c 'cd /haptics && exec ./run "$@"' sh $1
}

for call; do
  say "$release: $call"
  started=$(date +%s)
  if run_call "$call"; then
    say "$release: $call: passed in $(($(date +%s) - started)) s"
  else
    code=$?
    say "$release: $call: FAILED with exit code $code after $(($(date +%s) - started)) s"
    exit "$code"
  fi
done
