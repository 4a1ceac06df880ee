#!/bin/sh
# Fails when a C++ file is not formatted by .clang-format.
set -eu
cd "$(dirname "$0")/../.."
find core delegate testenv -name '*.h' -o -name '*.cpp' | sort | xargs clang-format --dry-run -Werror
