#!/bin/sh
#: build             build the stack below build/, with the Python package (called by the others when needed)
. "$(dirname "$0")/parts/start.sh"
[ $# = 0 ] || fail "build takes no arguments"
setup run python
build_stack all
