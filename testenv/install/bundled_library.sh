#!/bin/sh
# Links Embree, OpenSubdiv, OpenColorIO and Imath statically into the library, and measures what that saves a host.
#   bundled_library.sh SOURCES BUILD
# SOURCES holds their unpacked sources in the versions of Debian 12, and those of the libraries that OpenColorIO needs: folders
# embree*, opensubdiv*, OpenColorIO*, Imath*, expat (with a lib/expat.h), pystring* and yaml-cpp*. BUILD is made. About 20 minutes.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
sources=$(cd "$1" && pwd)
mkdir -p "$2"
build=$(cd "$2" && pwd)
prefix=$build/prefix

# static NAME FOLDER [OPTION ...]: builds a library for the prefix. GNU_UNIQUE symbols would keep ours from being unloaded.
static() {
  name=$1 folder=$2
  shift 2
  cmake -S "$folder" -B "$build/$name" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_PREFIX_PATH="$prefix" -DBUILD_SHARED_LIBS=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON \
    -DCMAKE_CXX_FLAGS=-fno-gnu-unique "$@" >"$build/$name.log"
  cmake --build "$build/$name" -j2 >>"$build/$name.log"
  cmake --install "$build/$name" >>"$build/$name.log"
}

static imath "$(echo "$sources"/Imath*/)" -DBUILD_TESTING=OFF
static expat "$(dirname "$(dirname "$(echo "$sources"/*/expat/lib/expat.h)")")" -DEXPAT_SHARED_LIBS=OFF -DEXPAT_BUILD_TESTS=OFF \
  -DEXPAT_BUILD_EXAMPLES=OFF -DEXPAT_BUILD_TOOLS=OFF
static yaml-cpp "$(echo "$sources"/yaml-cpp*/)" -DYAML_CPP_BUILD_TESTS=OFF -DYAML_CPP_BUILD_TOOLS=OFF
c++ -O2 -fPIC -fno-gnu-unique -c "$(echo "$sources"/pystring*/pystring.cpp)" -o "$build/pystring.o"
ar rcs "$prefix/lib/libpystring.a" "$build/pystring.o"
mkdir -p "$prefix/include/pystring"
cp "$sources"/pystring*/pystring.h "$prefix/include/pystring/"
# Version 2.1.2 lacks an include that g++ 12 asks for.
static opencolorio "$(echo "$sources"/OpenColorIO*/)" -DOCIO_INSTALL_EXT_PACKAGES=NONE -DOCIO_BUILD_APPS=OFF -DOCIO_BUILD_TESTS=OFF \
  -DOCIO_BUILD_GPU_TESTS=OFF -DOCIO_BUILD_PYTHON=OFF -DOCIO_BUILD_DOCS=OFF -DOCIO_BUILD_OPENFX=OFF -DOCIO_WARNING_AS_ERROR=OFF \
  -DCMAKE_CXX_FLAGS="-fno-gnu-unique -include cstring"
static opensubdiv "$(echo "$sources"/opensubdiv*/)" -DNO_OMP=1 -DNO_TBB=1 -DNO_CUDA=1 -DNO_OPENCL=1 -DNO_OPENGL=1 -DNO_EXAMPLES=1 \
  -DNO_TUTORIALS=1 -DNO_REGRESSION=1 -DNO_TESTS=1 -DNO_DOC=1 -DNO_PTEX=1
# Embree 3.13.5 would install TBB with its static library, and cannot where TBB is found by its own package. Debian's
# source leaves out a file that it installs.
[ -d "$build/embree_source" ] || cp -r "$(echo "$sources"/embree*/)" "$build/embree_source"
touch "$build/embree_source/readme.pdf"
sed -i 's/^IF (EMBREE_STATIC_LIB)/IF (FALSE)/' "$build/embree_source/common/cmake/installTBB.cmake"
static embree "$build/embree_source" -DEMBREE_STATIC_LIB=ON -DEMBREE_ISPC_SUPPORT=OFF -DEMBREE_TUTORIALS=OFF \
  -DEMBREE_TASKING_SYSTEM=TBB

cmake -S "$here/../.." -B "$build/ours" -G Ninja -DCMAKE_BUILD_TYPE=Release -DALABASTER_BUNDLE=ON -DCMAKE_PREFIX_PATH="$prefix" \
  -DALABASTER_TESTS=OFF -DALABASTER_BENCHMARKS=OFF >"$build/ours.log"
grep Bundle "$build/ours.log"
cmake --build "$build/ours" -j2 >>"$build/ours.log"
cmake --install "$build/ours" --prefix "$build/installed" >>"$build/ours.log"

# The contract's suite on it, and the cost of loading.
cmake -S "$here/../conformance" -B "$build/conformance" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$build/installed;$prefix" >"$build/conformance.log"
cmake --build "$build/conformance" -j2 >>"$build/conformance.log"
library=$(find "$build/installed" -name libhdAlabaster.so)
"$(find "$build/conformance" -name delegate_conformance -type f)" --library "$library" --repeat 0.01 --gtest_brief=1
cc -std=c99 -O2 -I "$build/installed/include" "$here/load_probe.c" -o "$build/load_probe" -ldl
python3 "$here/library_load.py" "$build/load_probe" "$library" "$here/../scenes/thick_thin/thick_thin.json" \
  "$here/../scenes/lights/lights.json"
