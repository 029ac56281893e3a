#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Line coverage of the tests by module: tools/coverage.sh [MODULE...]
# Builds in build/coverage (gcov), runs the tests (of those modules only) and prints a Markdown table.
# Lines that never ran: tools/coverage.py --missed MODULE. JOBS: tests and compilers at a time (2).
set -eu
cd "$(dirname "$0")/.."
jobs=${JOBS:-2}
cmake --preset coverage --log-level=WARNING >&2
find build/coverage -name '*.gcda' -delete
if [ $# -eq 0 ]; then
  cmake --build --preset coverage -j "$jobs" >&2
  ctest --preset coverage -j "$jobs" --no-tests=error >&2
else
  cmake --build --preset coverage -j "$jobs" --target $(printf 'collinea_%s_tests ' "$@") >&2
  ctest --preset coverage -j "$jobs" --no-tests=error -R "^($(IFS='|'; echo "$*"))/" >&2
fi
python3 tools/coverage.py --jobs "$jobs"
