#!/bin/sh
#: setup [SECTION...]
#:                   install the Debian packages of packages.apt: all, or those of the sections run, pages, npm, view,
#:                   python, unit, test, bench, fuzz, report, package, docs (each verb installs its own when needed)
. "$(dirname "$0")/parts/start.sh"
judge setup builds=text -- "$@"
[ -z "$option_builds" ] || { SETUP_BUILDS=$option_builds && shift 2; }  # what the verb that calls this through sudo builds next
known=$(package_sections)
for section; do
  echo "$known" | grep -qx -- "$section" || fail "setup: no section '$section' in packages.apt; there are: $(echo "$known" | tr '\n' ' ')"
done
# shellcheck disable=SC2086 # one word per section
[ $# -gt 0 ] || set -- $known
setup "$@"
give_to_caller
