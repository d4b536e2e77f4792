#!/usr/bin/env bash
# Installs what is missing, builds with g++ (release, and under the address and undefined-behaviour sanitizers) and
# with clang, warnings as errors, and tests. FACETSORT_MESH_PATH, a list of folders, adds meshes to test on.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=apps/packages.sh
source apps/packages.sh

install_packages "${facetsort_packages[@]}" clang
use_ccache

echo "== building: release, g++"
CXX=g++ cmake --preset release -DFACETSORT_WARNINGS_AS_ERRORS=ON
cmake --build --preset release
echo "== building: dev, clang"
CXX=clang++ cmake --preset dev -B build/dev-clang
cmake --build build/dev-clang
echo "== building: asan, g++"
CXX=g++ cmake --preset asan
cmake --build --preset asan

echo "== testing: release, g++"
ctest --preset release --parallel "$(nproc)"
echo "== testing: asan, g++"
ctest --preset asan --parallel "$(nproc)"
