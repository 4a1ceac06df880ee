#!/bin/sh
# Builds Alabaster and renders. Without arguments it renders the bundled sample scene into build/quickstart/ (EXR and
# PNG). Arguments are passed to `alabaster render`. Installs missing Debian packages; may be run again.
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
. "$top/testenv/install_packages.sh"
install_packages "$top/testenv/packages.txt"

build="$top/build/release"
cmake -S "$top" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DALABASTER_TESTS=OFF -DALABASTER_BENCHMARKS=OFF >/dev/null
cmake --build "$build" --target alabaster
install_denoiser "$build"
denoise=""
[ ! -e "$build/oidn" ] || denoise="--denoise"

if [ $# -gt 0 ]; then
  exec "$build/bin/alabaster" render "$@"
fi
out="$top/build/quickstart"
mkdir -p "$out"
"$build/bin/alabaster" render "$top/testenv/scenes/sample/sample.json" \
  -o "$out/sample.exr" -o "$out/sample.png" --stats "$out/sample.stats.json" \
  --aov albedo --aov normal --aov depth --aov subsurface $denoise
python3 - "$out" "$denoise" <<'PYTHON'
import json, sys
out, denoise = sys.argv[1:]
stats = json.load(open(out + "/sample.stats.json"))
phases = stats["phases"]
layers = "albedo, normal, depth, subsurface" + (", denoised" if denoise else "")
print("Done:\n  %s/sample.exr  scene-linear, with the layers %s\n  %s/sample.png  display-ready%s" %
      (out, layers, out, ", denoised" if denoise else ", as rendered: without a denoiser, 20 samples are grainy"))
print("Time: " + ", ".join("%s %.1f s" % (name, phase["wall"]) for name, phase in phases.items()) +
      "; peak memory %.0f MB." % (stats["peakMemory"] / 1e6))
PYTHON
