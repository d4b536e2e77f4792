#!/usr/bin/env bash
# Makes the golden pictures again with a built program: tests/apps/golden/make.sh PROGRAM
set -euo pipefail
program=$(realpath "$1")
golden=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$golden/../../.."
while read -r name allowed arguments; do
  if [[ -z $name || $name == \#* ]]; then
    continue
  fi
  echo "$name (up to $allowed pixels may differ)"
  # The arguments hold no blanks of their own.
  # shellcheck disable=SC2086
  "$program" blend $arguments -o "$golden/$name.png" >/dev/null
done < "$golden/pictures.txt"
