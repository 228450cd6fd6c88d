#!/bin/sh
# Builds the libFuzzer target of contacts with clang, sanitizers included, and runs it for a bounded time (./run bench fuzz):
# run.sh BUILD_FOLDER [SECONDS]. What it learned stays in BUILD_FOLDER/corpus.
set -eu
folder=$1 seconds=${2:-20}
mkdir -p "$folder/corpus"
cmake -S "$(dirname "$0")" -B "$folder" -G Ninja -DCMAKE_CXX_COMPILER=clang++
ninja -C "$folder" contact_fuzz
exec "$folder/contact_fuzz" -max_total_time="$seconds" -seed=1 -max_len=40 -timeout=10 -print_final_stats=1 \
  -artifact_prefix="$folder/" "$folder/corpus"
