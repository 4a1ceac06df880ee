#!/bin/sh
# Builds Alabaster and runs its tests; in CI (environment variable CI set) warnings are errors. Installs missing Debian
# packages; may be run again.
#   run_tests.sh [--long] [--nightly] [--hosts] [--systems] [--sanitize address,undefined | --sanitize thread] [[--] arguments for ctest]
# Without an option: the tests labelled fast, and what they need is built. --long: also those labelled long. --hosts: also
# those labelled host, whose programs (Blender, Slurm, openjd-cli, OpenUSD) it installs. --systems: on Debian 12 and 13 from
# bare (systems/run_systems.sh, needs root); alone, nothing else. --nightly: also those labelled nightly, for hours.
# Arguments for ctest without one of these options choose from all tests (-R kill_and_resume).
# Environment: ALABASTER_TEST_ASSETS names a folder of glTF test files (sss, subdiv, valid, invalid). Without it, tests
# that need it report that they were skipped. The last lines name what did not run, and why.
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
sanitize="" build="$top/build/release" labels="" systems="" hosts_wanted="" configuration=Release
while [ $# -gt 0 ]; do
  case $1 in
    --long) labels="$labels|long" ;;
    --nightly) labels="$labels|nightly" configuration=nightly ;;
    --hosts) labels="$labels|host" hosts_wanted=yes ;;
    --systems) systems=yes ;;
    --sanitize)
      [ $# -gt 1 ] || { echo "error: --sanitize needs address,undefined or thread" >&2; exit 2; }
      sanitize=$2
      build="$top/build/sanitize-$(echo "$2" | tr ',' '-')"
      shift ;;
    --) shift; break ;;
    --*) echo "error: there is no option $1; options of ctest follow --" >&2; exit 2 ;;
    *) break ;;
  esac
  shift
done
if [ -n "$systems" ]; then
  failed=0
  sh "$top/testenv/systems/run_systems.sh" || failed=$?
  [ -n "$labels$sanitize" ] || [ $# -gt 0 ] || exit "$failed"
  export SYSTEMS_RAN=yes
  [ "$failed" -eq 0 ] || { echo "error: --systems failed; the other tests were not started" >&2; exit "$failed"; }
fi
target=all
if [ -n "$labels" ]; then
  set -- -L "^(fast$labels)\$" "$@"
elif [ $# -eq 0 ]; then
  set -- -L '^fast$'
  target=fast_tests
fi

. "$top/testenv/install_packages.sh"
install_packages "$top/testenv/packages.txt" "$top/testenv/packages_tests.txt" "$top/testenv/packages_window.txt"
hydra_options=""
if [ -n "$hosts_wanted" ]; then
  mkdir -p "$top/build"
  . "$top/testenv/install_hosts.sh"
  install_hosts
  PATH="$top/build/hosts/bin:$PATH"
  export PATH
fi
werror=OFF
[ -z "${CI:-}" ] || werror=ON
# shellcheck disable=SC2086  # options are meant to be split
cmake -S "$top" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DALABASTER_WERROR=$werror -DALABASTER_TESTS=ON \
  -DALABASTER_BENCHMARKS=OFF "-DALABASTER_SANITIZE=$sanitize" $hydra_options
cmake --build "$build" -j "$(nproc)" --target $target
# The thread sanitizer sees neither the library's locks nor its TBB.
[ "$sanitize" = "thread" ] || install_denoiser "$build"
# Never required: tests of stages are skipped without it.
[ -e "$top/build/usd/pxr" ] || { need_pip; "$build/bin/alabaster" usd install; } || echo "OpenUSD for Python: not installed"
export LSAN_OPTIONS="suppressions=$top/testenv/sanitizers/leak_suppressions ${LSAN_OPTIONS:-}"
export TSAN_OPTIONS="suppressions=$top/testenv/sanitizers/thread/suppressions ${TSAN_OPTIONS:-}"
export UBSAN_OPTIONS="print_stacktrace=1 ${UBSAN_OPTIONS:-}"
cd "$build"
rm -f junit.xml
ctest -C nightly --show-only=json-v1 > every_test.json
failed=0
ctest --output-on-failure --output-junit junit.xml --test-output-size-passed 10000000 -C "$configuration" -j "$(nproc)" "$@" || failed=$?
python3 "$top/testenv/not_run.py" junit.xml every_test.json
exit "$failed"
