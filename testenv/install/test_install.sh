#!/bin/sh
# Installs a build into a fresh prefix, then configures, builds and runs another project against it.
#   test_install.sh BUILD_FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$1" --prefix "$scratch/prefix" >/dev/null
cmake -S "$here" -B "$scratch/build" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$scratch/build"
"$scratch/build/stranger"
"$scratch/prefix/bin/alabaster" --version | head -n 1
for schema in disney_material lights camera render_settings render_description quality_presets; do
  test -s "$scratch/prefix/share/alabaster/schemas/$schema.json"
done
# The headers installed are those of the contract, and each compiles on its own.
headers=$(cd "$scratch/prefix/include/alabaster" && find . -name '*.h' | sort)
test "$(echo "$headers" | wc -l)" -ge 13
for header in $headers; do
  echo "#include \"$header\"" | c++ -std=c++20 -fsyntax-only -x c++ -I "$scratch/prefix/include/alabaster" \
    $(pkg-config --cflags Imath 2>/dev/null || echo -I/usr/include/Imath) -
done
