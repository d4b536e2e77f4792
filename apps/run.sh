#!/usr/bin/env bash
# From a fresh Debian 12 to a report: installs what is missing, builds, and compares the strategies.
#
#   bash apps/run.sh [MESH...] [OPTION...]
#
# MESHes stand before the options and replace the shipped ones. OPTIONs are those of `facetsort compare`; the report
# goes to ./report of the project unless --out says otherwise. For example:
#
#   bash apps/run.sh my.ply --views 12 --size 1024
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=apps/packages.sh
source "$root/apps/packages.sh"

meshes=()
while (($# > 0)) && [[ $1 != -* ]]; do
  meshes+=("$1")
  shift
done
if ((${#meshes[@]} == 0)); then
  meshes=("$root"/meshes/*.ply)
fi
out=(--out "$root/report")
for option in "$@"; do
  if [[ $option == --out || $option == --out=* ]]; then
    out=()
  fi
done

install_packages "${facetsort_packages[@]}"
use_ccache
echo "== building"
(cd "$root" && cmake --preset release && cmake --build --preset release --target facetsort)
echo "== comparing ${#meshes[@]} mesh(es)"
exec "$root/build/release/apps/facetsort/facetsort" compare "${meshes[@]}" "${out[@]}" "$@"
