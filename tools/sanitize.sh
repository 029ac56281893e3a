#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs the tests under sanitizers: tools/sanitize.sh asan|tsan [MODULE...]
#   asan: AddressSanitizer (with leaks) and UndefinedBehaviorSanitizer; tsan: ThreadSanitizer. Any finding fails its test.
# Builds in build/asan or build/tsan. Without modules all of them: hours of processor time at first, with a compiler
# cache minutes afterwards. JOBS: tests and compilers at a time (2).
set -eu
cd "$(dirname "$0")/.."
kind=${1:-}; shift || true
jobs=${JOBS:-2}
case $kind in
  asan) export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:quarantine_size_mb=64 UBSAN_OPTIONS=print_stacktrace=1
        export LSAN_OPTIONS=print_suppressions=0 ;;
  tsan) export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:suppressions=$PWD/tools/tsan.supp ;;
  *) sed -n '3,6s/^# //p' "$0"; exit 2 ;;
esac
cmake --preset "$kind" --log-level=WARNING
fixed=; ! command -v setarch > /dev/null || fixed="setarch -R"  # kernels that scatter addresses widely are more than they can follow
if [ $# -eq 0 ]; then
  cmake --build --preset "$kind" -j "$jobs"
  $fixed ctest --preset "$kind" -j "$jobs" --no-tests=error
else
  cmake --build --preset "$kind" -j "$jobs" --target $(printf 'collinea_%s_tests ' "$@")
  $fixed ctest --preset "$kind" -j "$jobs" --no-tests=error -R "^($(IFS='|'; echo "$*"))/"
fi
