#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes the readers of files from outside: tools/fuzz.sh [TARGET] [RUNS] [SECONDS]
# Builds with clang, AddressSanitizer and UndefinedBehaviorSanitizer in build/fuzz, then gives each target (or the one)
# so many inputs (a million), within so many seconds a target (0: as many as it takes), from its seeds, from fuzz/corpus
# and from what earlier calls found worth keeping. An input may take 10 seconds and 1 GiB. Calls add up: build/fuzz/runs
# holds what each target has done; a finding ends the call, its input lies in build/fuzz/found/TARGET, and the count begins
# anew. A target that has them all reads its whole corpus again with a search for leaks, which costs too much for every
# input. Prints a line for each target. COLLINEA_FUZZ_PARTS: processes that share a target's inputs (1);
# COLLINEA_FUZZ_NO_BUILD: takes the fuzzer that is there. Needs clang and libclang-rt-dev.
set -eu
cd "$(dirname "$0")/.."
wanted=${1:-all}; runs=${2:-1000000}; seconds=${3:-0}; parts=${COLLINEA_FUZZ_PARTS:-1}
[ -n "${COLLINEA_FUZZ_NO_BUILD:-}" ] || { cmake --preset fuzz --log-level=WARNING; cmake --build --preset fuzz --target collinea_fuzz; }
fuzzer=$PWD/build/fuzz/bin/collinea_fuzz
export UBSAN_OPTIONS=print_stacktrace=1
sanitizer=quarantine_size_mb=16:malloc_context_size=2
# Readers of whole files get them from memory.
export TMPDIR=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)/collinea_fuzz.XXXXXX")
trap 'rm -rf "$TMPDIR"' EXIT

total() { awk "$1" "build/fuzz/runs/$target"; }  # over all calls: runs, seconds, peak MB

# One process's inputs and time of this call, without those that it read only to begin.
note_runs() {
  stat() { sed -n "s/^stat::$1: *//p" "$2" | tail -1; }
  local executed=$(stat number_of_executed_units "$1") begun=$(sed -n 's/^#\([0-9]*\)\tINITED.*/\1/p' "$1" | tail -1)
  echo "$((${executed:-0} - ${begun:-0})) $(($(date +%s) - began)) $(stat peak_rss_mb "$1")" >> "build/fuzz/runs/$target"
}

fuzz() {
  local work=build/fuzz/corpus/$target found=build/fuzz/found/$target log=build/fuzz/$target.log
  mkdir -p "$work" "$found" build/fuzz/runs; touch "build/fuzz/runs/$target"
  # Runs count for the program that was fuzzed: another build begins anew.
  local made=$(sha256sum "$fuzzer" | cut -d' ' -f1)
  [ "$(cat "build/fuzz/runs/.$target" 2>/dev/null)" = "$made" ] || { : > "build/fuzz/runs/$target"; echo "$made" > "build/fuzz/runs/.$target"; }
  export COLLINEA_FUZZ_TARGET=$target
  COLLINEA_FUZZ_SEEDS=$work "$fuzzer"
  local known=(); [ ! -d "fuzz/corpus/$target" ] || known=("fuzz/corpus/$target")
  # Twice the longest seed: what is longer only costs time.
  local longest=$(find "$work" -name 'seed-*' -printf '%s\n' | sort -n | tail -1) verdict=
  local options=(-timeout=10 -rss_limit_mb=1024 -max_len=$((longest < 512 ? 1024 : 2 * longest)) "-artifact_prefix=$found/")
  local left=$((runs - $(total '{n += $1} END {print n + 0}'))) began=$(date +%s)
  if [ "$left" -gt 0 ]; then
    left=$(((left + parts - 1) / parts + $(find "$work" "${known[@]}" -type f | wc -l) + 2))
    local part status=0 processes=()
    for part in $(seq "$parts"); do
      ASAN_OPTIONS=$sanitizer:detect_leaks=0 "$fuzzer" "${options[@]}" -runs="$left" -max_total_time="$seconds" \
          -print_final_stats=1 "$work" "${known[@]}" > "$log.$part" 2>&1 & processes+=($!)
    done
    for part in $(seq "$parts"); do
      wait "${processes[part - 1]}" || { status=$?; verdict="FOUND, see $log.$part"; }
      note_runs "$log.$part"
    done
    [ "$status" -ne 72 ] || { echo "$target: interrupted" >&2; exit 130; }
  fi
  if [ -z "$verdict" ] && [ "$(total '{n += $1} END {print n + 0}')" -ge "$runs" ]; then
    if ASAN_OPTIONS=$sanitizer:detect_leaks=1 "$fuzzer" "${options[@]}" -runs=0 "$work" "${known[@]}" > "$log.leaks" 2>&1
    then verdict=clean
    else
      [ $? -ne 72 ] || { echo "$target: interrupted" >&2; exit 130; }
      verdict="FOUND, see $log.leaks"
    fi
  fi
  printf '%-16s %s  %s\n' "$target" "$(total '{n += $1; s += $2; if ($3 > m) m = $3}
      END {printf "%8d runs %6d /s %5d MB", n, n / (s ? s : 1), m}')" "${verdict:-clean so far}"
  case $verdict in FOUND*) : > "build/fuzz/runs/$target"; bad=1;; esac
}

targets=$wanted; bad=0
[ "$wanted" != all ] || targets=$("$fuzzer" 2>&1 | tail -n +2 || true)
[ -n "$targets" ] || { echo "no targets: $fuzzer is missing or broken" >&2; exit 1; }
for target in $targets; do fuzz; done
exit $bad
