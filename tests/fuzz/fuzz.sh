#!/bin/sh
# Builds the fuzzers, or runs one of them for WARPSCOPE_FUZZ_S seconds (10): fuzz.sh SOURCES BUILD build|FUZZER
# Its dice begin with WARPSCOPE_FUZZ_SEED (1), so that a run can be repeated; 0 is another beginning each time, for long runs.
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
        -DWARPSCOPE_FUZZ=ON -DWARPSCOPE_UNITY=ON -DWARPSCOPE_CUDA=OFF -DWARPSCOPE_TESTS=OFF -DWARPSCOPE_WITH_UI=OFF -DWARPSCOPE_WITH_ITK=OFF \
        -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)"
      cmake --build "$build" --target fuzzers
      for part in codec net session volume; do
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
# Frames and headers of text are longer than messages.
case $what in codec_fuzz | client_session_fuzz | nrrd_fuzz | meta_image_fuzz) longest=65536 ;; *) longest=4096 ;; esac
# What is read may take neither more memory than this, sanitizers included, nor more seconds.
# What is found is a failure: by itself libFuzzer exits with 77 and 70, and 77 says that a test was skipped.
set -- -error_exitcode=1 -timeout_exitcode=1 -max_total_time="${WARPSCOPE_FUZZ_S:-10}" -seed="${WARPSCOPE_FUZZ_SEED:-1}" -max_len="$longest" -timeout=10 -rss_limit_mb=2048 -verbosity=0 \
  -artifact_prefix="$build/findings/$what-"
case $what in
  client_session_fuzz) set -- "$@" -malloc_limit_mb=64 -rss_limit_mb=1024 ;;  # a client asks for pictures of 64 x 48 pixels
  nrrd_fuzz | meta_image_fuzz | mrc_fuzz | nifti_fuzz)
    # ITK forgets some memory when it refuses a file. What it prints would reach a terminal: see volume_fuzz.cpp.
    export ASAN_OPTIONS="detect_leaks=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}"
    set -- "$@" -malloc_limit_mb=512 -detect_leaks=0 -close_fd_mask=3
    ;;
esac
rm -f -- "$build/findings/$what"-*
# One that hangs where libFuzzer does not look ends as well.
timeout "$((${WARPSCOPE_FUZZ_S:-10} + 120))" "$build/tests/fuzz/$what" "$@" "$build/seeds/$what" && exit 0
# A log alone must be enough to repeat it.
for finding in "$build/findings/$what"-*; do
  if [ -e "$finding" ]; then
    echo "$finding, in base64 (base64 -d FILE > input; $what input):"
    base64 "$finding"
  fi
done
exit 1
