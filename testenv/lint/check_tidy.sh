#!/bin/sh
# Fails when clang-tidy finds a fault. A file takes ten seconds of a core, so CI gives it those that changed last.
#   check_tidy.sh BUILD [FILE...]   BUILD has compile_commands.json; without a FILE all of core and delegate
set -eu
cd "$(dirname "$0")/../.."
build=$1
shift
[ $# -gt 0 ] || set -- $(git ls-files 'core/*.cpp' 'delegate/*.cpp')
# Files of parts that are not configured have no command.
for file; do ! grep -q "/$file\"" "$build/compile_commands.json" || echo "$file"; done |
  xargs -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unused-command-line-argument 2>/dev/null
