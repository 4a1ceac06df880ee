#!/bin/sh
# Searches for inputs that break a promise: builds the fuzz targets with clang++ and sanitizers, and runs each.
#   search.sh SECONDS [TARGET...]
# As many targets run at once as there are processors. An input that was found lies in build/fuzz/found; put it into
# testenv/fuzz/corpus/TARGET once it is mended. New inputs that only reach further are kept in build/fuzz/corpus.
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
seconds=${1:?usage: search.sh SECONDS [TARGET...]}
shift
[ $# -gt 0 ] || set -- gltf description archive override mesh material image image_format ocio checkpoint job c_api path
. "$top/testenv/install_packages.sh"
install_packages "$top/testenv/packages.txt" "$top/testenv/packages_tests.txt" "$top/testenv/packages_fuzz.txt"

build=$top/build/fuzz
cmake -S "$top" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++ -DALABASTER_FUZZ=ON \
  -DALABASTER_SANITIZE=address,undefined -DALABASTER_BENCHMARKS=OFF >/dev/null
targets=""
for target in "$@"; do targets="$targets fuzz_$target"; done
# shellcheck disable=SC2086
cmake --build "$build" -j "$(nproc)" --target $targets
mkdir -p "$build/found"
# Debian's libraries allocate with malloc and free with delete now and then.
export ASAN_OPTIONS="alloc_dealloc_mismatch=0:detect_leaks=0:allocator_may_return_null=1 ${ASAN_OPTIONS:-}"
export UBSAN_OPTIONS="print_stacktrace=1 ${UBSAN_OPTIONS:-}"
export top build seconds

# One target. Its report is printed at once, so that those of others do not run into it.
search='
target=$1
log=$build/found/$target.log
mkdir -p "$build/corpus/$target"
# Limits and kept inputs, for the replay and for the search.
set -- -timeout=120 -rss_limit_mb=3000 -malloc_limit_mb=2000 "-artifact_prefix=$build/found/$target-" "$top/testenv/fuzz/corpus/$target"
[ "$target" != gltf ] || set -- "$@" "$top/testenv/unit/delegate/gltf/translations"
if ! "$build/bin/fuzz_$target" -runs=0 "$@" >"$log" 2>&1; then
  printf "%s: a kept input fails; %s says why\n" "$target" "$log"
  exit 255
fi
status=0
"$build/bin/fuzz_$target" -max_total_time="$seconds" -max_len=20000 -seed="${ALABASTER_FUZZ_SEED:-0}" -print_final_stats=1 \
  "$build/corpus/$target" "$@" >"$log" 2>&1 || status=1
times >"$log.times"  # the second line is that of children
report=$(grep -E "number_of_executed_units|ERROR|SUMMARY|broken promise|runtime error" "$log" | sed "s/^/$target: /")
report="$report
$target: CPU time with the replay, user and system: $(tail -n 1 "$log.times")"
[ $status = 0 ] || report="$report
$target: failed; $log says why"
printf "%s\n" "$report"
exit $status'
printf '%s\n' "$@" | xargs -n 1 -P "$(nproc)" sh -c "$search" search.sh
