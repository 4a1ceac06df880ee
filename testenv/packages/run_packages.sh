#!/bin/sh
# Makes the two .deb and the wheel, and tries them: the wheel in a fresh virtual environment, the .deb in a bare chroot of this
# system (root and debootstrap; else it says that it did not).
#   run_packages.sh [BUILD_FOLDER]    by default build/release, which is built where the program is missing
# The packages remain in BUILD_FOLDER and in build/wheel/dist.
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$top/build/release}
. "$top/testenv/install_packages.sh"
install_packages "$top/testenv/packages.txt" "$top/testenv/packages_window.txt" "$top/testenv/packages/packages.txt" || { echo "skipped: packages are missing"; exit 77; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

if [ ! -e "$build/bin/alabaster-tradeoff" ] || [ -z "$(find "$build/python/hdalabaster" -name '*.so' 2>/dev/null)" ]; then
  cmake -S "$top" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null
  cmake --build "$build" --target alabaster alabaster-tradeoff alabaster_images
  cmake --build "$build" --target alabaster_python alabaster-view
fi
rm -f "$build"/hdalabaster_*.deb "$build"/hdalabaster-usd_*.deb
(cd "$build" && cpack -G DEB >"$scratch/cpack.log" 2>&1) || { cat "$scratch/cpack.log"; exit 1; }
deb=$(ls "$build"/hdalabaster_*.deb)
(cd "$scratch" && python3 -m pip download --quiet --no-deps --timeout 10 --retries 1 --dest probe wheel >/dev/null 2>&1) ||
  { echo "skipped: the .deb was made; the wheel needs PyPI"; exit 77; }
sh "$top/delegate/packages/make_usd_deb.sh" "$build"
usd=$(ls "$build"/hdalabaster-usd_*.deb)
python3 "$top/delegate/packages/make_wheel.py" >"$scratch/wheel.log" 2>&1 || { tail -n 40 "$scratch/wheel.log"; exit 1; }
wheel=$(ls "$top"/build/wheel/dist/*.whl)
du -m "$deb" "$wheel"

# The wheel: the program and the module, each to a picture, without this build.
/usr/bin/python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet --disable-pip-version-check "$wheel"
scene="$top/testenv/scenes/sample/sample.json"
"$scratch/venv/bin/alabaster" render "$scene" -o "$scratch/wheel.png" -o "$scratch/wheel.exr" --size 96x64 --spp 4 --quiet
"$scratch/venv/bin/alabaster" tradeoff "$scratch/missing.json" 2>&1 | grep -q 'missing\.json: There is no such file'
(cd "$scratch" && venv/bin/python - "$scene" <<'PYTHON'
import sys
import hdalabaster
scene = hdalabaster.Scene()
loaded = scene.load(sys.argv[1])
render = hdalabaster.Renderer(scene, samples=2).render(settings=loaded["settings"], width=48, height=32)
assert sum(bytes(render["color"])) > 0, "the picture is black"
assert "site-packages" in hdalabaster.__file__, hdalabaster.__file__
print("module of the wheel:", hdalabaster.versions.replace("\n", ", "))
PYTHON
)
"$build/bin/alabaster" render "$scene" -o "$scratch/built.exr" --size 96x64 --spp 4 --quiet
# OpenColorIO of the wheel is another version: colours may differ by one step of a half.
oiiotool "$scratch/built.exr" --ch R,G,B "$scratch/wheel.exr" --ch R,G,B --fail 0.002 --warn 0.002 --diff
# The extra [denoise] brings the denoiser; without it --denoise is refused by a sentence that names what to install.
denoised="render $scene -o $scratch/denoised.exr --denoise --size 96x64 --spp 4 --quiet"
# shellcheck disable=SC2086  # the arguments are meant to be split
if "$scratch/venv/bin/alabaster" $denoised 2>"$scratch/refused.txt"; then echo "error: denoised without a denoiser"; exit 1; fi
grep -q pyoidn "$scratch/refused.txt" || { cat "$scratch/refused.txt"; exit 1; }
"$scratch/venv/bin/pip" install --quiet --disable-pip-version-check "$wheel[denoise]"
# shellcheck disable=SC2086
"$scratch/venv/bin/alabaster" $denoised
# [usd] brings OpenUSD; without it a stage is refused by the command that installs it.
printf '#usda 1.0\ndef Sphere "s"\n{\n}\n' >"$scratch/stage.usda"
if HOME=$scratch "$scratch/venv/bin/alabaster" check "$scratch/stage.usda" 2>"$scratch/refused.txt"; then echo "error: a stage without OpenUSD"; exit 1; fi
grep -q 'alabaster usd install' "$scratch/refused.txt" || { cat "$scratch/refused.txt"; exit 1; }
"$scratch/venv/bin/pip" install --quiet --disable-pip-version-check "$wheel[usd]"
"$scratch/venv/bin/alabaster" render "$scratch/stage.usda" -o "$scratch/stage.png" --size 64x64 --spp 4 --quiet
oiiotool --info -v "$scratch/denoised.exr" | grep -q 'denoised\.R' || { echo "error: no layer denoised"; exit 1; }
ls "$scratch"/venv/lib/python3*/site-packages/hdalabaster-*.dist-info/licenses/alabaster.txt >/dev/null

# The .deb in a bare system.
if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap >/dev/null; then
  echo "skipped: the .deb was made, not installed: that needs root and debootstrap"
  exit 0
fi
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
sh "$top/testenv/packages/try_in_chroot.sh" "$suite" --deb "$deb" --usd "$usd" --wheel "$wheel"
