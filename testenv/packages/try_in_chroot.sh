#!/bin/sh
# Installs the packages in a Debian that has nothing else, and renders there. Prints the seconds from the installation's
# begin to the first picture. Needs root and debootstrap.
#   try_in_chroot.sh SUITE [--deb FILE [--usd FILE]] [--wheel FILE] [--folder DIR]     SUITE: bookworm or trixie
# --usd: the .deb of OpenUSD, which reads a stage without a network.
# Without --deb and --wheel both are made first, in another chroot of SUITE (packages depend on the system that made them).
# The bare chroot is kept in DIR, by default build/chroots, as an archive: only its first use takes debootstrap's minute.
set -eu
top=$(cd "$(dirname "$0")/../.." && pwd)
suite=$1 deb="" usd="" wheel="" folder="$top/build/chroots"
shift
while [ $# -gt 0 ]; do
  case $1 in
    --deb) deb=$2 ;;
    --usd) usd=$2 ;;
    --wheel) wheel=$2 ;;
    --folder) folder=$2 ;;
    *) echo "error: unknown argument $1" >&2; exit 2 ;;
  esac
  shift 2
done
[ "$(id -u)" -eq 0 ] || { echo "error: chroots need root" >&2; exit 1; }
mirror=${DEBIAN_MIRROR:-$(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | grep -E '^(deb |URIs:)' |
  grep -oE 'https?://[^ ]+' | head -n 1)}
mkdir -p "$folder"
if [ ! -e "$folder/$suite.tar" ]; then
  debootstrap --variant=minbase "$suite" "$folder/$suite" "$mirror" >"$folder/$suite.log"
  tar -C "$folder/$suite" -cf "$folder/$suite.part" . && mv "$folder/$suite.part" "$folder/$suite.tar"
  rm -rf --one-file-system "${folder:?}/$suite"
fi

root=""
leave() {
  [ -n "$root" ] || return 0
  for place in proc dev/shm dev; do
    if mountpoint -q "$root/$place"; then umount "$root/$place" || return 1; fi
  done
  rm -rf --one-file-system "$root"
  root=""
}
trap leave EXIT

# A bare system in $root, with this machine's settings for registries of packages.
enter() {
  leave
  root=$(mktemp -d "$folder/$suite.XXXXXX")
  chmod 755 "$root"
  tar -C "$root" -xf "$folder/$suite.tar"
  mount -t proc proc "$root/proc"
  mount --bind /dev "$root/dev"
  mkdir -p "$root/dev/shm" && mount -t tmpfs tmpfs "$root/dev/shm"
  for file in /etc/resolv.conf /etc/hosts /etc/pip.conf /etc/ssl/certs/ca-certificates.crt /etc/apt/apt.conf.d/*proxy*; do
    if [ -e "$file" ]; then mkdir -p "$root$(dirname "$file")" && cp "$file" "$root$file"; fi
  done
  mkdir "$root/tried"
}
inside() {
  chroot "$root" env -i HOME=/root PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive sh -ec "$1"
}
# measure NAME COMMAND: the command renders /tried/picture.png.
measure() {
  cp -r "$top/testenv/scenes/sample" "$root/tried/"
  begin=$(date +%s.%N)
  inside "apt-get update -qq
    $2" >"$folder/$suite.$1.log" 2>&1 || { tail -n 20 "$folder/$suite.$1.log" >&2; exit 1; }
  end=$(date +%s.%N)
  [ -s "$root/tried/picture.png" ] || { echo "error: $1 wrote no picture" >&2; exit 1; }
  echo "$suite: $1 to the first picture: $(echo "$end $begin" | awk '{printf "%.1f", $1 - $2}') s, $(du -sxm "$root" | cut -f 1) MB of system"
}
render="alabaster render /tried/sample/sample.json -o /tried/picture.png --size 240x160 --spp 4 --quiet"

if [ -z "$deb$wheel" ]; then
  enter
  mkdir "$root/alabaster"
  git -C "$top" archive HEAD | tar -x -C "$root/alabaster"
  inside "cd /alabaster && apt-get update -qq && sh testenv/packages/run_packages.sh"
  deb=$folder/$suite.deb
  cp "$root"/alabaster/build/release/hdalabaster_*.deb "$deb"
  usd=$folder/$suite.usd.deb
  cp "$root"/alabaster/build/release/hdalabaster-usd_*.deb "$usd"
  cp "$root"/alabaster/build/wheel/dist/*.whl "$folder/"
  wheel=$folder/$(basename "$root"/alabaster/build/wheel/dist/*.whl)
fi
if [ -n "$deb" ]; then
  enter
  cp "$deb" "$root/tried/hdalabaster.deb"
  measure deb "apt-get install -y -qq --no-install-recommends /tried/hdalabaster.deb
    $render
    python3 -c 'import hdalabaster; print(hdalabaster.__version__)'
    test -s /usr/share/doc/hdalabaster/copyright && test -s /usr/share/bash-completion/completions/alabaster"
  # A stage: one command is named, with python3 or without; the package of OpenUSD needs no network.
  printf '#usda 1.0\ndef Sphere "s"\n{\n}\n' >"$root/tried/stage.usda"
  for path in /usr/bin /nowhere; do
    inside "code=0; env PATH=$path /usr/bin/alabaster check /tried/stage.usda 2>/tried/said || code=\$?
      [ \$code -eq 3 ] && grep -q 'alabaster usd install' /tried/said" || { cat "$root/tried/said" >&2; exit 1; }
  done
  echo "$suite: without OpenUSD a stage ends with exit 3 and the command that installs it"
  if [ -n "$usd" ]; then
    cp "$usd" "$root/tried/hdalabaster-usd.deb"
    inside "apt-get install -y -qq --no-install-recommends /tried/hdalabaster-usd.deb" >"$folder/$suite.usd.log" 2>&1 || { tail -n 20 "$folder/$suite.usd.log" >&2; exit 1; }
    begin=$(date +%s.%N)
    unshare -n chroot "$root" env -i HOME=/root PATH=/usr/bin:/bin alabaster render /tried/stage.usda -o /tried/stage.png --size 64x64 --spp 4 --quiet
    end=$(date +%s.%N)
    [ -s "$root/tried/stage.png" ] || { echo "error: no picture of the stage" >&2; exit 1; }
    echo "$suite: a stage by the package of OpenUSD, without a network: $(echo "$end $begin" | awk '{printf "%.1f", $1 - $2}') s"
  fi
  # The window, on a screen without a monitor: it is still open after 10 s.
  inside "apt-get install -y -qq --no-install-recommends xvfb xauth libgl1-mesa-dri
    opened=0
    xvfb-run -a timeout 10 alabaster view /tried/sample/sample.json || opened=\$?
    sleep 2  # the screen ends, which holds /dev
    [ \$opened -eq 124 ]" >"$folder/$suite.window.log" 2>&1 || { tail -n 20 "$folder/$suite.window.log" >&2; exit 1; }
  echo "$suite: the window of the .deb opens"
fi
if [ -n "$wheel" ]; then
  enter
  cp "$wheel" "$root/tried/"
  measure wheel "apt-get install -y -qq --no-install-recommends python3-venv
    python3 -m venv /tried/venv
    /tried/venv/bin/pip install -q --disable-pip-version-check /tried/*.whl
    PATH=/tried/venv/bin:\$PATH
    $render
    python3 -c 'import hdalabaster; print(hdalabaster.__version__)'"
fi
