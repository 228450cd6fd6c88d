#!/bin/sh
#: setup [SECTION...]
#:                   install the Debian packages of packages.apt: all, or those of the sections run, pages, npm, view,
#:                   python, test, bench, fuzz, report, package, docs (each verb installs its own when needed)
. "$(dirname "$0")/parts/start.sh"
known=$(package_sections)
for section; do
  echo "$known" | grep -qx -- "$section" || fail "setup: no section '$section' in packages.apt; there are: $(echo "$known" | tr '\n' ' ')"
done
# shellcheck disable=SC2086 # one word per section
[ $# -gt 0 ] || set -- $known
setup "$@"
