#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes the readers of files from outside: tools/fuzz.sh [TARGET] [RUNS]
# Builds with clang, AddressSanitizer and UndefinedBehaviorSanitizer in build/fuzz, then gives each target (or the one)
# so many inputs (a million), from its seeds and fuzz/corpus. A finding ends that target; its input lies in
# build/fuzz/found/TARGET. An input may take 10 seconds and 1 GiB. Needs clang and libclang-rt-dev.
set -eu
cd "$(dirname "$0")/.."
wanted=${1:-all}; runs=${2:-1000000}
[ -n "${COLLINEA_FUZZ_NO_BUILD:-}" ] || { cmake --preset fuzz --log-level=WARNING; cmake --build --preset fuzz --target collinea_fuzz; }
fuzzer=$PWD/build/fuzz/bin/collinea_fuzz
export ASAN_OPTIONS=quarantine_size_mb=16:malloc_context_size=8:detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1
# Readers of whole files get them from memory.
export TMPDIR=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)/collinea_fuzz.XXXXXX")
trap 'rm -rf "$TMPDIR"' EXIT
targets=$wanted
[ "$wanted" != all ] || targets=$("$fuzzer" 2>&1 | tail -n +2 || true)
bad=0
for target in $targets; do
  work=build/fuzz/corpus/$target; found=build/fuzz/found/$target; log=build/fuzz/$target.log
  mkdir -p "$work" "$found"
  COLLINEA_FUZZ_TARGET=$target COLLINEA_FUZZ_SEEDS=$work "$fuzzer"
  known=(); [ ! -d "fuzz/corpus/$target" ] || known=("fuzz/corpus/$target")
  if COLLINEA_FUZZ_TARGET=$target "$fuzzer" -runs="$runs" -timeout=10 -rss_limit_mb=1024 -max_len=16384 \
      -print_final_stats=1 -artifact_prefix="$found/" "$work" "${known[@]}" > "$log" 2>&1; then verdict=clean
  else verdict="FOUND, see $log"; bad=1; fi
  stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -1; }
  printf '%-16s %9s runs %7s /s %5s MB  %s\n' "$target" "$(stat number_of_executed_units)" \
    "$(stat average_exec_per_sec)" "$(stat peak_rss_mb)" "$verdict"
done
exit $bad
