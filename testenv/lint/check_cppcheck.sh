#!/bin/sh
# Fails when cppcheck finds a fault in core or delegate (apt-get install cppcheck). Ten minutes of a core, so it is no test of ctest.
#   check_cppcheck.sh [FOLDER]      FOLDER keeps what was found, for the next run
set -eu
cd "$(dirname "$0")/../.."
found=${1:-$(mktemp -d)}
mkdir -p "$found"
exec cppcheck --quiet --std=c++20 --enable=warning,performance,portability --max-configs=1 -I . --cppcheck-build-dir="$found" \
  --suppress=missingIncludeSystem --suppressions-list=testenv/lint/cppcheck_suppressions.txt --error-exitcode=1 core delegate
