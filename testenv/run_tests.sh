#!/bin/sh
# Builds everything and runs every test; in CI (environment variable CI set) warnings are errors. Installs missing
# Debian packages; may be run again.
#   run_tests.sh [--sanitize address,undefined | --sanitize thread] [arguments for ctest]
# Environment: ALABASTER_TEST_ASSETS names a folder of glTF test files (sss, subdiv, valid, invalid). Without it, tests
# that need it report that they were skipped.
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
. "$top/testenv/install_packages.sh"
install_packages "$top/testenv/packages.txt" "$top/testenv/packages_tests.txt" "$top/testenv/packages_window.txt"

sanitize=""
build="$top/build/release"
if [ "${1:-}" = "--sanitize" ]; then
  sanitize=$2
  build="$top/build/sanitize-$(echo "$2" | tr ',' '-')"
  shift 2
fi
werror=OFF
[ -z "${CI:-}" ] || werror=ON
cmake -S "$top" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DALABASTER_WERROR=$werror -DALABASTER_TESTS=ON \
  -DALABASTER_BENCHMARKS=ON "-DALABASTER_SANITIZE=$sanitize"
cmake --build "$build" -j "$(nproc)"
# The thread sanitizer sees neither the library's locks nor its TBB.
[ "$sanitize" = "thread" ] || install_denoiser "$build"
export LSAN_OPTIONS="suppressions=$top/testenv/sanitizers/leak_suppressions ${LSAN_OPTIONS:-}"
export TSAN_OPTIONS="suppressions=$top/testenv/sanitizers/thread/suppressions ${TSAN_OPTIONS:-}"
export UBSAN_OPTIONS="print_stacktrace=1 ${UBSAN_OPTIONS:-}"
cd "$build"
# A test that hangs is ended after half an hour; sanitizers take longer.
limit=1800
[ -z "$sanitize" ] || limit=14400
exec ctest --timeout "$limit" --output-on-failure -j "$(nproc)" "$@"
