#!/bin/sh
# Builds Alabaster and renders the bundled sample scene into build/quickstart/ (EXR and PNG), 480x320 pixels in twenty
# seconds. Installs missing Debian packages; may be run again.
#   quickstart.sh [--large | arguments of alabaster render]
# --large: 960x640 pixels, as at the top of README. Other arguments are passed to `alabaster render` instead.
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
. "$top/testenv/install_packages.sh"
install_packages "$top/testenv/packages.txt"
need_pip

build="$top/build/release"
cmake -S "$top" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DALABASTER_TESTS=OFF -DALABASTER_BENCHMARKS=OFF >/dev/null
install_denoiser "$build" &  # it is installed while the program compiles
denoiser=$!
cmake --build "$build" --target alabaster || { code=$?; wait "$denoiser" || true; exit "$code"; }
wait "$denoiser" || true
denoise=""
[ ! -e "$build/oidn" ] || denoise="--denoise"

size=480x320
[ "${1:-}" != --large ] || { size=960x640; shift; }
case " $* " in
  *.usd\ * | *.usda\ * | *.usdc\ * | *.usdz\ *)  # OpenUSD may lie elsewhere, too
    printf '#usda 1.0\ndef Cube "c"\n{\n}\n' >"$build/cube.usda"
    "$build/bin/alabaster" check "$build/cube.usda" >/dev/null 2>&1 || "$build/bin/alabaster" usd install ;;
esac
if [ $# -gt 0 ]; then
  exec "$build/bin/alabaster" render "$@"
fi
out="$top/build/quickstart"
mkdir -p "$out"
"$build/bin/alabaster" render "$top/testenv/scenes/sample/sample.json" \
  -o "$out/sample.exr" -o "$out/sample.png" --stats "$out/sample.stats.json" \
  --aov albedo --aov normal --aov depth --aov subsurface --size $size $denoise
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
