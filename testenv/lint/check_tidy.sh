#!/bin/sh
# Fails when clang-tidy finds a fault (apt-get install clang-tidy). A file takes ten seconds of a core, so CI looks at those that
# changed last.
#   check_tidy.sh BUILD [FILE...]   BUILD has compile_commands.json; without a FILE all of core and delegate
#   check_tidy.sh BUILD --last N    of them the N that changed last
set -eu
cd "$(dirname "$0")/../.."
build=$1
shift
if [ "${1:-}" = --last ]; then
  set -- $(git log --name-only --format= -300 -- 'core/*.cpp' 'delegate/*.cpp' | awk -v most="$2" \
    'system("test -f " $0) == 0 && !seen[$0]++ && n++ < most')
elif [ $# -eq 0 ]; then
  set -- $(git ls-files 'core/*.cpp' 'delegate/*.cpp')
fi
# Files of optional parts that were not configured have no command.
for file; do grep -q "$file\"" "$build/compile_commands.json" && echo "$file"; done |
  xargs -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet --warnings-as-errors='*' \
    --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unused-command-line-argument 2>/dev/null
