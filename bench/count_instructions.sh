#!/usr/bin/env bash
# bench/count_instructions.sh BUILD_FOLDER: instructions a facet of Sorter::sort_indices, by callgrind, which no other
# load on the machine can change. Writes bench/results/instructions.txt.
set -euo pipefail
program=$1/bench/facetsort-instructions
out=$(dirname "$0")/results/instructions.txt
{
  echo "Instructions a facet, keys to 32-bit index buffer, one thread, mean of 16 views of a knot in spatial order,"
  echo "the first frame's allocations and the clearing of counters, which callgrind counts by the byte, included."
  echo "Made by: bench/count_instructions.sh BUILD_FOLDER (release build, $(c++ --version | head -1); AVX2)"
  for facets in 20000 200000; do
    counted=$(valgrind --tool=callgrind --toggle-collect='facetsort::Sorter::sort_indices*' \
      --callgrind-out-file=/dev/null "$program" $facets 2>&1 | sed -n 's/.*Collected : //p')
    echo "$facets facets: $(awk -v i="$counted" -v n=$facets 'BEGIN { printf "%.1f", i / n / 16 }')"
  done
} > "$out"
cat "$out"
