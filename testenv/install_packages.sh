# Sourced by quickstart.sh and run_tests.sh. install_packages LIST... installs the packages of the lists that are
# missing.

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
  echo "Installing Debian packages:$missing"
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq
  # shellcheck disable=SC2086  # the list is meant to be split
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
}
