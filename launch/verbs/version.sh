#!/bin/sh
#: --version         which version this is, of which commit
. "$(dirname "$0")/parts/start.sh"
echo "haptics $(sed -n 's/^project(haptic_core VERSION \([0-9.]*\).*/\1/p' src/CMakeLists.txt) ($(commit))"
