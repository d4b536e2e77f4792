# What the scripts share: the packages of Debian 12 that the project needs, and how the missing ones are installed.
# Sourced by bash scripts; not run.
# shellcheck shell=bash
# shellcheck disable=SC2034  # the list is used where this is sourced

# What building, running and testing take; gnuplot draws the plots of the report page.
facetsort_packages=(
  g++ cmake ninja-build
  libglm-dev libtbb-dev libhwy-dev libboost-dev libembree-dev libopenmesh-dev libopenimageio-dev
  nlohmann-json3-dev libtinygltf-dev libcli11-dev libgtest-dev libbenchmark-dev
  gnuplot-nox
)

# install_packages PACKAGE...: installs those that are missing; says in one line why it can't.
install_packages() {
  local package missing=() as_root=()
  for package in "$@"; do
    if [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]]; then
      missing+=("$package")
    fi
  done
  if ((${#missing[@]} == 0)); then
    return
  fi
  if ((EUID != 0)); then
    as_root=(sudo)
  fi
  if ! command -v apt-get >/dev/null || { ((EUID != 0)) && ! command -v sudo >/dev/null; }; then
    echo "error: these packages are missing and neither root with apt-get nor sudo is here to install them:" \
         "${missing[*]}" >&2
    return 1
  fi
  echo "== installing ${missing[*]}"
  "${as_root[@]}" apt-get update --quiet=2
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install --yes --quiet=2 --no-install-recommends "${missing[@]}"
}

# Rebuilds are faster with ccache where it is there; nothing needs it.
use_ccache() {
  if command -v ccache >/dev/null; then
    export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}
  fi
}
