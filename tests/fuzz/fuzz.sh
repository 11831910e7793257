#!/bin/sh
# Builds the fuzzers, or runs one of them for WARPSCOPE_FUZZ_S seconds (10): fuzz.sh SOURCES BUILD build|FUZZER
# Exit code 77: there is no clang with libFuzzer, so nothing was tested.
set -eu
sources=$1 build=$2 what=$3

if [ "$what" = build ]; then
  probe=$(mktemp -d)
  trap 'rm -rf -- "$probe"' EXIT
  echo 'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }' > "$probe/probe.cpp"
  for clang in clang clang-19 clang-18 clang-17 clang-16 clang-15 clang-14; do
    compiler=$(printf %s "$clang" | sed 's/clang/clang++/')
    if "$compiler" -std=c++20 -fsanitize=fuzzer,address "$probe/probe.cpp" -o "$probe/probe" 2> "$probe/log"; then
      rm -f -- "$build/none"
      cmake -S "$sources" -B "$build" -G Ninja -DCMAKE_C_COMPILER="$clang" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_CXX_FLAGS_RELEASE=-O1 \
        -DWARPSCOPE_FUZZ=ON -DWARPSCOPE_CUDA=OFF -DWARPSCOPE_TESTS=OFF -DWARPSCOPE_WITH_UI=OFF -DWARPSCOPE_WITH_ITK=OFF \
        -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)"
      cmake --build "$build" --target fuzzers
      for part in codec net session; do
        "$build/tests/fuzz/${part}_fuzz_seeds" "$build/seeds"
      done
      exit 0
    fi
  done
  mkdir -p -- "$build" && touch "$build/none"
  echo "Skipped: no clang with libFuzzer (Debian: apt-get install clang libclang-rt-dev)." && exit 77
fi

if [ -e "$build/none" ]; then
  echo "Skipped: no clang with libFuzzer." && exit 77
fi
mkdir -p -- "$build/findings"
# Frames are longer than messages. What a client takes of a server is bounded by what it asked: pictures of 64 x 48 pixels.
longest=4096 limits=
case "$what" in
  codec_fuzz) longest=65536 ;;
  client_session_fuzz) longest=65536 limits="-malloc_limit_mb=64 -rss_limit_mb=1024" ;;
esac
exec "$build/tests/fuzz/$what" -max_total_time="${WARPSCOPE_FUZZ_S:-10}" -max_len="$longest" -timeout=10 -print_final_stats=1 $limits \
  -artifact_prefix="$build/findings/$what-" "$build/seeds/$what"
