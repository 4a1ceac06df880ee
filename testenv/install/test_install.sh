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
