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
library=$(find "$scratch/prefix" -name libhdAlabaster.so)

# The cost of loading.
cc -std=c99 -pedantic -Wall -Wextra -Werror -O2 "$here/load_probe.c" -o "$scratch/load_probe" -ldl
if readelf -d "$library" | grep -q 'NEEDED.*lib[at]san'; then
  echo "skipped: a library with sanitizers in it is not what hosts load"
else
  python3 "$here/library_load.py" "$scratch/load_probe" "$library"
fi

# Without the image library (libalabaster_images), a scene without images renders, and files say what is missing.
images=$(find "$scratch/prefix" -name 'libalabaster_images.so.0')
mv "$images" "$images.away"
"$scratch/build/stranger"
if "$scratch/prefix/bin/alabaster" render "$here/../scenes/thick_thin/thick_thin.json" --size 8x8 --spp 1 -o "$scratch/a.exr" 2>"$scratch/error"; then
  echo "error: an image was written without the image library" >&2
  exit 1
fi
grep -q "images cannot be read or written" "$scratch/error" || { cat "$scratch/error" >&2; exit 1; }
mv "$images.away" "$images"
"$scratch/prefix/bin/alabaster" render "$here/../scenes/thick_thin/thick_thin.json" --size 8x8 --spp 1 -o "$scratch/a.exr" --quiet

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
