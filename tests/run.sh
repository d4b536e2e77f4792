#!/usr/bin/env bash
# Installs what is missing, builds with warnings as errors and tests: with g++ as released, and with clang under the
# address and undefined-behaviour sanitizers. FACETSORT_MESH_PATH, a list of folders, adds meshes to test on.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=apps/packages.sh
source apps/packages.sh

install_packages "${facetsort_packages[@]}" clang libclang-rt-14-dev python3
use_ccache

echo "== building: release, g++"
CXX=g++ cmake --preset release -DFACETSORT_WARNINGS_AS_ERRORS=ON
cmake --build --preset release
echo "== building: asan, clang"
CXX=clang++ cmake --preset asan -B build/asan-clang
cmake --build build/asan-clang

jobs=$(nproc)
echo "== testing: release, g++"
ctest --test-dir build/release --output-on-failure --parallel "$jobs"
echo "== testing: asan, clang"
# What measures rates or installs is not done again.
left_out='^base\.Install|^check\.Meshes/Corpus|^order\.Precision|^presort\.IndexBuffers\.(Are|Measure|One)'
ctest --test-dir build/asan-clang --output-on-failure --parallel "$jobs" --exclude-regex "$left_out"
