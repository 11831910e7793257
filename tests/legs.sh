#!/usr/bin/env bash
# Builds and runs the numerical tests in other ways than the usual one: by another compiler, for older processors, with traps.
# Usage: legs.sh [LEG...]; a leg is a preset of CMakePresets.json. Each builds in build-LEG, of render/ and its tests only.
# Prints the closing lines of each leg's tests; exit code 1 if one does not build or a test fails.
set -euo pipefail
cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/.."

legs=("$@")
((${#legs[@]})) || legs=(baseline clang debug traps)
options=(-DWARPSCOPE_WERROR=ON -DWARPSCOPE_WITH_UI=OFF)
if command -v ccache >/dev/null; then
  options+=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
jobs=${WARPSCOPE_JOBS:-$(nproc)}

status=0
for leg in "${legs[@]}"; do
  log=build-$leg/leg.log
  mkdir -p "build-$leg"
  if cmake --preset "$leg" "${options[@]}" >"$log" 2>&1 && ninja -C "build-$leg" -j "$jobs" -k 0 unit_tests stability_tests >>"$log" 2>&1; then
    # Without tests of what is not built here: the program, its package, the other test programs.
    ctest --test-dir "build-$leg" -L '^(unit|stability)$' -E '^(package|tests|sources\.readme)' --output-on-failure --no-tests=error --parallel "$jobs" >>"$log" 2>&1 || status=1
    sed -n "/^[0-9]*% tests passed/,\$s/^/$leg: /p" "$log" | grep -v ': *$' || true
  else
    status=1
    echo "$leg: did not build:"
    tail -n 25 "$log"
  fi
done
exit "$status"
