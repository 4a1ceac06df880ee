#!/bin/sh
# Makes the .deb hdalabaster-usd: OpenUSD and MaterialX for this system's Python, where the program of the .deb hdalabaster
# looks for them. Needs pip, binutils, dpkg-dev, and PyPI or a folder of wheels.
#   make_usd_deb.sh FOLDER [WHEELS]    writes FOLDER/hdalabaster-usd_VERSION_amd64.deb
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
chmod 755 "$root"
packages=$(grep -oE '(usd-core|MaterialX)==[0-9.]+' "$top/delegate/cli/usd_command.cpp" | sort -u)
version=$(echo "$packages" | sed -n 's/usd-core==//p')
next=$(/usr/bin/python3 -c 'import sys; print("3.%d" % (sys.version_info[1] + 1))')
this=$(/usr/bin/python3 -c 'import sys; print("3.%d" % sys.version_info[1])')
usd="$root/usr/lib/alabaster/usd" doc="$root/usr/share/doc/hdalabaster-usd"
mkdir -p "$usd" "$doc" "$root/DEBIAN"

# shellcheck disable=SC2086  # one package a word
/usr/bin/python3 -m pip install --quiet --disable-pip-version-check --no-deps --no-compile --only-binary :all: --target "$usd" \
  ${2:+--no-index} ${2:+--find-links="$2"} $packages
rm -rf "$usd/bin"  # programs of MaterialX
find "$usd" \( -name '*.so' -o -name '*.so.*' \) -exec strip --strip-unneeded {} +

for licence in "$usd"/*.dist-info/licenses/*; do
  echo "==== $(basename "$(dirname "$(dirname "$licence")")" .dist-info), $(basename "$licence") ===="
  cat "$licence"
done >"$doc/copyright"
printf 'hdalabaster-usd (%s) UNRELEASED; urgency=medium\n\n  * The wheels of PyPI: %s.\n\n -- %s  %s\n' "$version" "$(echo $packages)" \
  "Alabaster maintainers <maintainers@alabaster.example>" "$(date -R)" | gzip -9n >"$doc/changelog.gz"
cat >"$root/DEBIAN/control" <<CONTROL
Package: hdalabaster-usd
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: Alabaster maintainers <maintainers@alabaster.example>
Section: graphics
Priority: optional
Depends: python3 (>= $this), python3 (<< $next), libc6, libstdc++6
Enhances: hdalabaster
Installed-Size: $(du -sk "$root/usr" | cut -f 1)
Description: OpenUSD for the path tracer Alabaster
 PyPI's usd-core and MaterialX, with which the program alabaster reads stages of
 OpenUSD without a network.
CONTROL
mkdir -p "$1"
dpkg-deb --root-owner-group -Zgzip --build "$root" "$1" >/dev/null
du -m "$1"/hdalabaster-usd_*.deb
