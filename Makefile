# SPDX-License-Identifier: Apache-2.0
# The two commands of the README. Everything else: cmake --preset dev|release|asan|tsan, cmake --build --preset ...

.PHONY: demo test build setup

demo: build
	@tools/demo.sh

test: build
	@echo "== layers"
	@python3 tools/check_layers.py
	@python3 tools/check_flags.py
	@echo "== manual"
	@python3 tools/manual_options.py --check
	@echo "== tests"
	@ctest --preset release -j 2

build: setup
	@echo "== building (Release) in build/release"
	@cmake --preset release --log-level=WARNING > /dev/null
	@cmake --build --preset release

setup:
	@tools/setup.sh
