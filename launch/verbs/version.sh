#!/bin/sh
#: version           which version this is, of which commit, and which of its two libraries this processor runs (also --version)
. "$(dirname "$0")/parts/start.sh"
judge version -- "$@"
at_most 0 version 'no words'
echo "haptics $(sed -n 's/^project(haptic_core VERSION \([0-9.]*\).*/\1/p' src/CMakeLists.txt) ($(commit))"
library=$(chosen_library)
[ -z "$library" ] || echo "library $library"
