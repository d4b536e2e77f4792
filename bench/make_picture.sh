#!/usr/bin/env bash
# Makes bench/results/strategies.png, the README's picture: one mesh by four strategies, and below each where it
# differs from the reference. Needs the built program (bash apps/run.sh builds it).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mesh=tablefan_36k
strategies=(unsorted separate_culling_pass facet_sort:centroid_distance reference)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

list=$(IFS=,; echo "${strategies[*]}")
"$root/build/release/apps/facetsort/facetsort" compare "$root/meshes/$mesh.ply" --strategies "$list" --views 3 \
  --repeats 1 --size 512 --out "$work/report" >/dev/null

{
  echo "set terminal pngcairo size 1640,860 background rgb 'white' font 'sans,13'"
  echo "set output '$work/strategies.png'"
  echo "unset tics; unset border; unset key; set size ratio -1; set margins 0, 0, 0, 0"
  echo "set multiplot layout 2,4 margins 0.005,0.995,0.005,0.95 spacing 0.005,0.005"
  for strategy in "${strategies[@]}"; do
    echo "set title '$strategy' noenhanced offset 0,-0.6"
    echo "plot '$work/report/pictures/$mesh.${strategy/:/.}.png' binary filetype=png with rgbimage"
  done
  echo "unset title"
  for strategy in "${strategies[@]:0:3}"; do
    echo "plot '$work/report/pictures/$mesh.${strategy/:/.}.difference.png' binary filetype=png with rgbimage"
  done
  echo "unset multiplot"
} | gnuplot
mv "$work/strategies.png" "$root/bench/results/strategies.png"
