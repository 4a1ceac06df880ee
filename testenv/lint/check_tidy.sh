#!/bin/sh
# Fails when clang-tidy finds a fault. A file takes ten seconds of a core, so CI gives it those that changed last.
#   check_tidy.sh [FILE...]   without a FILE all of core and delegate
set -eu
cd "$(dirname "$0")/../.."
# clang-tidy needs the command of each file by itself.
build=build/tidy
cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DALABASTER_UNITY=OFF -DALABASTER_TESTS=OFF -DALABASTER_BENCHMARKS=OFF >/dev/null
[ $# -gt 0 ] || set -- $(git ls-files 'core/*.cpp' 'delegate/*.cpp')
# Files of parts that are not configured have no command.
for file; do ! grep -q "/$file\"" "$build/compile_commands.json" || echo "$file"; done |
  xargs -r -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unused-command-line-argument 2>/dev/null
