#!/bin/sh
# Installs a build into a fresh prefix, then configures, builds and runs another project against it.
#   test_install.sh BUILD_FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
touch "$scratch/begin"
told=$(cmake --install "$1" --prefix "$scratch/prefix")
written=$(find "$1/blender" -newer "$scratch/begin" 2>/dev/null || true)
[ -z "$written" ] || { echo "error: the installation wrote outside of its prefix: $written" >&2; exit 1; }
# Each optional part is installed, or the installation says why not.
for part in "Python module:_hdalabaster*.so" "Blender add-on:alabaster_render.zip" "Window:alabaster-view" "Command tradeoff:alabaster-tradeoff" "Denoiser:libOpenImageDenoise.so.2" "Hydra plug-in:hdAlabasterPlugin.so"; do
  found=$(find "$scratch/prefix" -name "${part#*:}")
  left_out=$(echo "$told" | grep "^-- ${part%%:*}.*: not installed, because " || true)
  if [ -n "$found" ] && [ -n "$left_out" ] || [ -z "$found$left_out" ]; then
    echo "error: ${part%%:*}: found '$found', told '$left_out'" >&2
    exit 1
  fi
done
cmake -S "$here" -B "$scratch/build" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$scratch/build"
"$scratch/build/stranger"
"$scratch/prefix/bin/alabaster" --version | head -n 1
[ ! -e "$scratch/prefix/bin/alabaster-tradeoff" ] || "$scratch/prefix/bin/alabaster" tradeoff missing.json 2>&1 | grep -q "missing.json"
[ ! -e "$scratch/prefix/bin/alabaster-view" ] || "$scratch/prefix/bin/alabaster" view --help >/dev/null
library=$(find "$scratch/prefix" -name libhdAlabaster.so)
libraries=$(dirname "$library")

# A scene that hosts and the program render alike.
python3 - "$here/../scenes/thick_thin" "$scratch" <<'PYTHON'
import json, shutil, sys
folder, scratch = sys.argv[1:]
scene = json.load(open(folder + "/thick_thin.json"))
shutil.copy(folder + "/thick_thin.glb", scratch)  # a scene names files in its own folder
scene["settings"] = {"samples": 4, "resolution": [48, 32]}
scene["products"] = [{"file": scratch + "/program.exr", "dataType": "float"}]
json.dump(scene, open(scratch + "/scene.json", "w"))
PYTHON
"$scratch/prefix/bin/alabaster" render "$scratch/scene.json" --quiet

# A project of four lines for each language. It asks for an old standard, and has the one that the target needs.
#   make_host TARGET LANGUAGE SOURCE WARNINGS
make_host() {
  mkdir "$scratch/$1"
  cat >"$scratch/$1/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.25)
project(Host LANGUAGES $2)
set(CMAKE_NO_SYSTEM_FROM_IMPORTED ON)  # the warnings are for the headers, too
find_package(hdAlabaster 0.1 REQUIRED)
add_executable(host $here/$3)
target_link_libraries(host PRIVATE hdAlabaster::$1)
CMAKE
  cmake -S "$scratch/$1" -B "$scratch/$1/build" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_DISABLE_FIND_PACKAGE_Imath=ON -DCMAKE_C_STANDARD=90 -DCMAKE_CXX_STANDARD=98 \
    "-DCMAKE_$2_FLAGS=-pedantic -Wall -Wextra -Werror" --no-warn-unused-cli >/dev/null
  cmake --build "$scratch/$1/build"
}

# The C interface: a host in C99 without any other header.
make_host c C host.c
"$scratch/c/build/host" "$scratch/scene.json" "$scratch/host_c.pfm"
oiiotool "$scratch/program.exr" --ch R,G,B "$scratch/host_c.pfm" --fail 0 --warn 0 --diff

# A host in C++17 on the same interface, and one in Python.
make_host cpp17 CXX host.cpp
"$scratch/cpp17/build/host" "$scratch/written.alab"
"$scratch/prefix/bin/alabaster" check "$scratch/written.alab" --quiet
module=$(find "$scratch/prefix" -name '_hdalabaster*.so')
if [ -n "$module" ]; then
  python=$(sed -n 's/^_Python_EXECUTABLE:INTERNAL=//p' "$1/CMakeCache.txt")
  PYTHONPATH=$(dirname "$(dirname "$module")") "${python:-python3}" "$here/../unit/python/alabaster_test.py" \
    "$scratch/prefix/bin/alabaster" Renders Documentation >"$scratch/python" 2>&1 || { cat "$scratch/python"; exit 1; }
  echo "Python host: $(tail -n 1 "$scratch/python")"
else
  echo "skipped: the Python module was not built (python3-dev, pybind11-dev)"
fi

# The contract's suite on the installed library.
"$1/bin/delegate_conformance" --library "$library" --repeat 0.01 --gtest_brief=1

# The cost of loading.
cc -std=c99 -O2 -I "$scratch/prefix/include" "$here/load_probe.c" -o "$scratch/load_probe" -ldl
python3 "$here/library_load.py" "$scratch/load_probe" "$library" "$scratch/scene.json" "$here/../scenes/lights/lights.json"

# Without the image library (libalabaster_images), a scene without images renders, and files say what is missing.
images=$(find "$scratch/prefix" -name 'libalabaster_images.so.0')
mv "$images" "$images.away"
"$scratch/build/stranger"
if "$scratch/prefix/bin/alabaster" render "$scratch/scene.json" -o "$scratch/a.exr" 2>"$scratch/error"; then
  echo "error: an image was written without the image library" >&2
  exit 1
fi
grep -q "images cannot be read or written" "$scratch/error" || { cat "$scratch/error" >&2; exit 1; }
mv "$images.away" "$images"
"$scratch/prefix/bin/alabaster" render "$scratch/scene.json" -o "$scratch/a.exr" --quiet

# The denoiser that is installed with the program, or one that lies there, is found without any variable.
oidn=$libraries/alabaster/oidn/lib
if [ ! -e "$oidn/libOpenImageDenoise.so.2" ]; then
  mkdir -p "$oidn"
  cp "$1/lib/libfake_oidn.so" "$oidn/libOpenImageDenoise.so.2"
fi
env -u ALABASTER_OIDN -u VIRTUAL_ENV HOME="$scratch" "$scratch/prefix/bin/alabaster" render "$scratch/scene.json" \
  -o "$scratch/denoised.exr" --denoise --quiet
oiiotool --info -v "$scratch/denoised.exr" | grep -q "denoised\.R"

for schema in disney_material textures mesh lights camera render_settings render_description quality_presets; do
  test -s "$scratch/prefix/share/alabaster/schemas/$schema.json"
done
# The headers installed are those of the contract, and each compiles on its own.
headers=$(cd "$scratch/prefix/include/alabaster" && find . -name '*.h' | sort)
imath=$(pkg-config --cflags Imath 2>/dev/null | sed 's/-I */-isystem /g')
test "$(echo "$headers" | wc -l)" -ge 14
for header in $headers; do
  echo "#include \"$header\"" | c++ -std=c++20 -pedantic -Wall -Wextra -Werror -fsyntax-only -x c++ \
    -I "$scratch/prefix/include/alabaster" ${imath:--isystem /usr/include/Imath} -
done

# A prefix that is relative: Blender runs elsewhere, so the add-on names the module's folder from the root on.
if [ -n "$module" ]; then
  build=$(cd "$1" && pwd)
  (cd "$scratch" && cmake --install "$build" --prefix relative >/dev/null)
  python3 - "$scratch/relative" <<'PYTHON'
import pathlib, sys, zipfile
prefix = pathlib.Path(sys.argv[1])
pack = zipfile.ZipFile(prefix / "share/alabaster/blender/alabaster_render.zip")
lines = [line for name in pack.namelist() for line in pack.read(name).decode().splitlines() if "dist-packages" in line]
if not any(line.startswith(str(prefix)) for line in lines):
    sys.exit(f"error: with a relative prefix the add-on looks for its module in {lines}")
PYTHON
fi
