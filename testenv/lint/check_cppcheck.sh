#!/bin/sh
# Fails when cppcheck finds a fault. All of core and delegate take ten minutes of a core, so CI gives it the files that changed last.
#   check_cppcheck.sh [FILE...]
set -eu
cd "$(dirname "$0")/../.."
[ $# -gt 0 ] || set -- core delegate
exec cppcheck --quiet --std=c++20 --enable=warning,performance,portability --max-configs=1 -I . --error-exitcode=1 \
  --suppress=missingIncludeSystem --suppressions-list=testenv/lint/cppcheck_suppressions.txt "$@"
