# Sourced by run_tests.sh --hosts. install_hosts installs the programs that Alabaster runs in: Blender and Slurm as Debian
# packages; openjd-cli, the module bpy and headers of its TBB from PyPI, in a virtual environment in build/hosts; headers of
# bpy's OpenUSD, from ALABASTER_USD_HEADERS or its repository. A program that cannot be installed is named with the reason, and
# its tests are skipped. Afterwards, hydra_options holds options for CMake, and build/hosts/bin the programs for PATH.

# of_host WHAT COMMAND...: runs a command of an installation and keeps its last line as the reason if it fails.
of_host() {
  what=$1
  shift
  if reason=$("$@" 2>&1); then
    echo "hosts: $what: installed"
  else
    echo "hosts: $what: not installed ($(echo "$reason" | grep . | tail -n 1))"
    return 1
  fi
}

# Blender ships no headers. Those of its OpenUSD are a check-out; pxr.h is made from pxr.h.in (delegate/hydra/README.md).
fetch_usd_headers() {
  [ -e "$1/pxr/pxr.h" ] && return 0
  [ ! -e "$1" ] || { echo "$1 exists and has no pxr/pxr.h: remove it, or name a folder that has"; return 1; }
  git clone --quiet --depth 1 --branch v24.05 "${ALABASTER_USD_REPOSITORY:-https://github.com/PixarAnimationStudios/OpenUSD}" "$1" || return 1
  sed -e 's/@PXR_MAJOR_VERSION@/0/;s/@PXR_MINOR_VERSION@/24/;s/@PXR_PATCH_VERSION@/5/;s/@PXR_VERSION@/2405/' \
    -e 's/@PXR_USE_NAMESPACES@/1/;s/@PXR_EXTERNAL_NAMESPACE@/pxr/;s/@PXR_INTERNAL_NAMESPACE@/pxrInternal_v0_24/' \
    -e 's/@PXR_PYTHON_SUPPORT_ENABLED@/0/;s/@PXR_PREFER_SAFETY_OVER_SPEED@/1/' "$1/pxr/pxr.h.in" > "$1/pxr/pxr.h"
}

pip_install() {
  "$hosts/venv/bin/pip" install --quiet --disable-pip-version-check "$@"
}

install_hosts() {
  hosts="$top/build/hosts"
  hydra_options=""
  for package in $(sed 's/#.*//' "$top/testenv/packages_hosts.txt"); do
    echo "$package" > "$top/build/package.part"
    of_host "package $package" install_packages "$top/build/package.part" || true
  done
  rm -f "$top/build/package.part"
  mkdir -p "$hosts/bin"
  of_host "virtual environment" python3 -m venv "$hosts/venv" || return 0
  if of_host "openjd-cli" pip_install openjd-cli; then ln -sfn "$hosts/venv/bin/openjd" "$hosts/bin/openjd"; fi
  # The last bpy with OpenUSD 24.05, which needs Python 3.11: that of Debian 12.
  of_host "bpy 4.3" pip_install bpy==4.3.0 'numpy<2' || return 0
  of_host "headers of bpy's TBB" pip_install --no-deps tbb-devel==2020.0.133 || true
  headers=${ALABASTER_USD_HEADERS:-$hosts/openusd}
  of_host "headers of OpenUSD 24.05" fetch_usd_headers "$headers" || return 0
  hydra_options="-DALABASTER_HYDRA=ON -DALABASTER_USD_HEADERS=$headers -DALABASTER_USD_LIBRARY=$(echo "$hosts"/venv/lib/python3*/site-packages/bpy/lib/libusd_ms.so)"
}
