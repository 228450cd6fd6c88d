#!/bin/sh
#: build             build the stack below build/, with the Python package (called by the others when needed)
. "$(dirname "$0")/parts/start.sh"
judge build -- "$@"
at_most 0 build 'no words'
SETUP_BUILDS=all
setup run python
build_stack all
# Of what this call compiled: all of it only from an empty folder.
warnings=$(grep -c -e ': warning: ' -e '^CMake Warning' "$LOGS/build.log")
rm -f "$FIGURES/build.csv" && echo "figure build.warnings $warnings 1" >"$LOGS/build.figures"
keep_figures build "$LOGS/build.figures" '-O3 -DNDEBUG -ffp-contract=off'
