#!/bin/sh
# Builds everything and runs every test; in CI (environment variable CI set) warnings are errors. Installs missing
# Debian packages; may be run again.
#   run_tests.sh [--sanitize address,undefined | --sanitize thread] [arguments for ctest]
# Environment: ALABASTER_TEST_ASSETS names a folder of glTF test files (sss, subdiv, valid, invalid). Without it, tests
# that need it report that they were skipped. The last lines name what did not run, and why.
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
rm -f junit.xml
ctest -C long --show-only=json-v1 > every_test.json
failed=0
ctest --output-on-failure --output-junit junit.xml --test-output-size-passed 10000000 -j "$(nproc)" "$@" || failed=$?
python3 "$top/testenv/not_run.py" junit.xml every_test.json
exit "$failed"
