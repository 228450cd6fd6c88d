#!/bin/sh
#: docs              the documentation as a site, with search, below build/docs/html: README, concepts, tutorials, messages, Python and
#:                   C++, and touch.html, on which scenes are touched; ends with how many symbols have no word (docs.undocumented) and
#:                   how many links lead nowhere
. "$(dirname "$0")/parts/start.sh"
judge docs -- "$@"
at_most 0 docs 'no words'
SETUP_BUILDS=stack
setup run python docs npm wasm
without=$(npm_reason)
[ -z "$without" ] || echo "docs: the page touch.html is left out: $without" >&2
build_stack 'haptic_python pack_scenes'
use_build
kept=$LOGS/docs.figures site=$ROOT/launch/doc/site
rm -rf "$BUILD/docs" && mkdir -p "$BUILD/docs" "$LOGS"
python3 -B "$site/collect.py" "$BUILD/docs/pages" >"$kept" || fail "docs: the pages of messages and Python could not be made; see $kept"
with_progress_or_log docs "$LOGS/docs.log" doxygen "$site/Doxyfile"
if [ -z "$without" ]; then
  (touch_page "$BUILD/docs/html/touch.html" index.html) || without="it could not be made; see above, and $LOGS"
fi
if [ -n "$without" ]; then  # links lead there
  echo "<!DOCTYPE html><title>Touch scenes</title><p>This page was left out when the site was made: $without. <a href=\"index.html\">Back</a>" \
    >"$BUILD/docs/html/touch.html"
fi
python3 -B "$site/links.py" --complete "$BUILD/docs/html"
python3 -B "$site/search_pages.py" "$BUILD/docs/html" >>"$kept"
grep '^docs: ' "$kept"
python3 -B "$site/links.py" "$BUILD/docs/html" >>"$kept"
code=$?
grep '^dead link' "$kept"
python3 -B "$site/undocumented.py" "$BUILD/docs/warnings.log" >"$LOGS/undocumented.log"
grep -v '^figure ' "$LOGS/undocumented.log"
grep '^figure ' "$LOGS/undocumented.log" >>"$kept"
awk '$2 ~ /^docs.undocumented_/ { sum += $3 } END { print "figure docs.undocumented", sum + 0, 1 }' "$kept" >"$LOGS/undocumented.sum"
cat "$LOGS/undocumented.sum" >>"$kept"
rm -f "$FIGURES/docs.csv"
keep_figures docs "$kept" ''
echo "docs: $BUILD/docs/html/index.html${without:+, without the page to touch scenes}; what has no word: $BUILD/docs/warnings.log"
exit "$code"
