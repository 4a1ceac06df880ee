#!/bin/sh
# Fails when a C++ file is not formatted by .clang-format. Each version of clang-format breaks some lines otherwise: ours
# is 14, that of Debian 12. Exit code 77: skipped, because there is another one.
set -eu
cd "$(dirname "$0")/../.."
program=$(command -v clang-format-14 || command -v clang-format || true)
case $([ -z "$program" ] || "$program" --version) in
*"version 14."*) ;;
*)
  echo "skipped: clang-format 14 is missing; 'pip install clang-format==14.0.6' brings it, where Debian does not"
  exit 77
  ;;
esac
find core delegate testenv -name '*.h' -o -name '*.cpp' | sort | xargs "$program" --dry-run -Werror
