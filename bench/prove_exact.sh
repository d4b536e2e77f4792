#!/usr/bin/env bash
# Judges the exact order of meshes over a large set of views: 32 eyes at each of 1.2, 2.5 and 10 bounding radii, 8 eyes
# inside with six views each, and 32 orthographic directions. One line a mesh; exits 1 where a pixel or a ray is wrong.
# Needs the built program (bash apps/run.sh builds it).
#
#   bash bench/prove_exact.sh [METHOD] SIZE MESH...     for example: bash bench/prove_exact.sh 1024 meshes/*.ply
#
# METHOD is exact, exact_tree or presorted; exact where there is none.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=$root/build/release/apps/facetsort/facetsort
method=exact
if [[ ${1:-} == exact* || ${1:-} == presorted ]]; then
  method=$1
  shift
fi
if [[ $# -lt 2 || ! -x $program ]]; then
  sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
size=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sets=("--views 32 --radii 1.2" "--views 32 --radii 2.5" "--views 32 --radii 10" "--inside 8" "--views 32 --ortho")

printf '%-18s %6s %12s %9s %7s %11s %9s %12s %13s %10s %12s\n' mesh views pixels inverted wrong miscovered unjudged \
  'Embree rays' 'Embree inv.' unjudged 'triangles x'
failed=0
for mesh in "$@"; do
  for i in "${!sets[@]}"; do
    # shellcheck disable=SC2086  # several words
    "$program" compare "$mesh" ${sets[$i]} --strategies "facet_sort:$method" --repeats 1 --size "$size" \
      --out "$work/$i" >/dev/null
  done
  awk -F, -v name="$(basename "${mesh%.*}")" '
    {  # commas within quotes part nothing
      count = split($0, piece, "\"")
      line = ""
      for (i = 1; i <= count; ++i) { if (i % 2 == 0) gsub(",", ";", piece[i]); line = line piece[i] }
      $0 = line
    }
    FNR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    function at(key) { return $column[key] }
    { ++views; pixels += at("covered_pixels"); inverted += at("inverted_pixels"); wrong += at("wrong_pixels")
      miscovered += at("miscovered_pixels"); unjudged += at("unjudged_pixels"); rays += at("embree_rays")
      embree += at("embree_inverted"); embree_unjudged += at("embree_unjudged")
      if (at("wrong_pixels") == "" || at("embree_inverted") == "") ++unanswered
      if (at("triangles_out") / at("facets") > growth) growth = at("triangles_out") / at("facets") }
    END { printf "%-18s %6d %12d %9d %7d %11d %9d %12d %13d %10d %12.3f", name, views, pixels, inverted, wrong,
            miscovered, unjudged, rays, embree, embree_unjudged, growth
          if (unanswered) printf "  %d views not judged", unanswered
          print ""
          exit inverted + wrong + miscovered + embree > 0 }' "$work"/*/results.csv || failed=1
done
exit "$failed"
