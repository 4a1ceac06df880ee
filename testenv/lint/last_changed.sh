#!/bin/sh
# Names the N files of core and delegate that changed last.
#   last_changed.sh N
set -eu
cd "$(dirname "$0")/../.."
git log --name-only --format= -300 -- 'core/*.cpp' 'delegate/*.cpp' |
  awk -v most="$1" '!seen[$0]++ && system("test -f " $0) == 0 && n++ < most'
