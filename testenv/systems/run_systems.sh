#!/bin/sh
# README's two commands and the packages on Debian and Ubuntu from bare, in a chroot each. Needs root; installs debootstrap.
# Keeps a row of results.md for each system: date, revision, versions and seconds.
#   run_systems.sh [bookworm] [trixie] [noble]     the two of Debian without an argument
# Environment: DEBIAN_MIRROR (else the first one of /etc/apt), UBUNTU_MIRROR (else archive.ubuntu.com), DEBOOTSTRAP_OPTIONS (for
# example --no-check-gpg where Ubuntu's keyring is missing), SYSTEMS_FOLDER (else build/systems; 6 GB for each system),
# ALABASTER_TEST_ASSETS (read-only in the chroot), SYSTEMS_STEPS (else "picture tests packages").
# The committed revision is tested, not the work tree. Exits with 1 if a step of a system failed.
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
here="$top/testenv/systems"
[ "$(id -u)" -eq 0 ] || { echo "error: chroots need root" >&2; exit 1; }
. "$top/testenv/install_packages.sh"
echo debootstrap > "${TMPDIR:-/tmp}/systems.$$"
install_packages "${TMPDIR:-/tmp}/systems.$$"
rm -f "${TMPDIR:-/tmp}/systems.$$"
mirror=${DEBIAN_MIRROR:-$(cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources 2>/dev/null |
  grep -E '^(deb |URIs:)' | grep -oE 'https?://[^ ]+' | head -n 1)}
folder=${SYSTEMS_FOLDER:-$top/build/systems}
steps=${SYSTEMS_STEPS:-picture tests packages}
[ $# -gt 0 ] || set -- bookworm trixie

# Unmounts the machine's folders below the root, which is removed only then.
leave() {
  for place in proc dev/shm dev/pts dev assets; do
    if mountpoint -q "$root/$place"; then umount "$root/$place" || return 1; fi
  done
}

enter() {
  mount -t proc proc "$root/proc"
  mount --bind /dev "$root/dev"
  mount -t tmpfs tmpfs "$root/dev/shm"
  mount --bind /dev/pts "$root/dev/pts"
  if [ -d "${ALABASTER_TEST_ASSETS:-}" ]; then
    mkdir -p "$root/assets"
    mount --bind -o ro "$ALABASTER_TEST_ASSETS" "$root/assets"
  fi
  cp /etc/resolv.conf /etc/hosts "$root/etc/"
  # The settings of this machine for registries of packages, if it has any.
  for file in /etc/pip.conf /etc/ssl/certs/ca-certificates.crt /etc/apt/apt.conf.d/*proxy*; do
    if [ -e "$file" ]; then mkdir -p "$root$(dirname "$file")" && cp "$file" "$root$file"; fi
  done
  # A copy that the package ca-certificates does not overwrite.
  certificates=""
  if [ -e /etc/ssl/certs/ca-certificates.crt ]; then
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/certificates_of_host.crt"
    certificates=PIP_CERT=/etc/certificates_of_host.crt
  fi
}

inside() {
  assets=""
  [ ! -d "$root/assets" ] || assets=ALABASTER_TEST_ASSETS=/assets
  # shellcheck disable=SC2086  # an empty assignment is none
  chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb $assets $certificates sh -c "cd /alabaster && $1"
}

# step NAME COMMAND: seconds of a step, or "failed", in the variable that has its name.
step() {
  case " $steps " in *" $1 "*) ;; *) eval "$1='not run'"; return 0 ;; esac
  begin=$(date +%s)
  echo "$release: $1"
  if inside "$2" > "$folder/$release.$1.log" 2>&1; then
    eval "$1=$(($(date +%s) - begin))"
  else
    failed=1
    eval "$1=failed"
    tail -n 20 "$folder/$release.$1.log"
  fi
}

version() {
  chroot "$root" dpkg-query -W -f='${source:Upstream-Version}' "$1" 2>/dev/null || echo none
}

failed=0
mkdir -p "$folder"
for release in "$@"; do
  root="$folder/$release"
  leave || { echo "error: $root is in use" >&2; exit 1; }
  rm -rf --one-file-system "$root"
  # shellcheck disable=SC2086  # options are meant to be split
  case $release in
    # Debian 12's debootstrap has no script of this name; that of jammy is the same.
    noble) debootstrap --variant=minbase --components=main,universe ${DEBOOTSTRAP_OPTIONS:-} "$release" "$root" \
      "${UBUNTU_MIRROR:-http://archive.ubuntu.com/ubuntu}" /usr/share/debootstrap/scripts/jammy ;;
    *) debootstrap --variant=minbase ${DEBOOTSTRAP_OPTIONS:-} "$release" "$root" "$mirror" ;;
  esac > "$folder/$release.debootstrap.log"
  mkdir "$root/alabaster"
  git -C "$top" archive HEAD | tar -x -C "$root/alabaster"
  trap leave EXIT
  enter
  step picture "sh testenv/quickstart.sh"
  step tests "sh testenv/run_tests.sh"
  packages="no script"
  if [ -e "$top/testenv/packages/run_packages.sh" ]; then step packages "sh testenv/packages/run_packages.sh"; fi
  system=$(. "$root/etc/os-release" && echo "$NAME" | sed 's| GNU/Linux||')
  number=$(. "$root/etc/os-release" && echo "$VERSION_ID")
  [ "$system" != Debian ] || number=$(cat "$root/etc/debian_version")
  revision=$(git -C "$top" rev-parse --short HEAD)
  versions="g++ $(chroot "$root" g++ -dumpfullversion), Embree $(version libembree-dev), OpenImageIO $(version libopenimageio-dev), OpenColorIO $(version libopencolorio-dev), Python $(version python3)"
  echo "| $(date -u +%F) | $revision | $system $number | $versions | $(nproc) | $picture | $tests | $packages |" >> "$here/results.md"
  leave
  trap - EXIT
done
exit "$failed"
