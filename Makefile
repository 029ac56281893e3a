# SPDX-License-Identifier: Apache-2.0
# The commands of the README. Everything else: cmake --preset dev|release|asan|tsan, cmake --build --preset ...
PREFIX ?= /usr/local
COLLINEA = build/release/bin/collinea

.PHONY: demo test program documents install deb setup

demo: program
	@COLLINEA=$(COLLINEA) tools/demo.sh

test: configured
	@echo "== building the program and its tests (Release) in build/release"
	@tools/build.py
	@echo "== layers"
	@python3 tools/check_layers.py
	@python3 tools/check_circles.py
	@python3 tools/check_flags.py
	@python3 tools/check_words.py
	@python3 tools/check_terms.py
	@python3 tools/check_numbers.py
	@echo "== manual"
	@python3 tools/manual_options.py --check
	@python3 tools/figures.py --check
	@echo "== tests"
	@ctest --preset release -j 2

program: configured
	@echo "== building the program (Release) in build/release"
	@tools/build.py collinea

documents: program
	@tools/man_pages.py --collinea $(COLLINEA) build/release/share

install: documents
	@cmake --install build/release --prefix $(PREFIX) --strip | tail -1
	@echo "== installed in $(PREFIX): collinea, collinea-demo, their man pages and the completion for bash"

deb: documents
	@PACKAGES="dpkg-dev file" tools/setup.sh
	@cd build/release && cpack -G DEB > cpack.log || (cat cpack.log; exit 1)
	@echo "== $$(ls -t build/release/collinea_*.deb | head -1): install it with apt install ./FILE"

.PHONY: configured
configured: setup
	@cmake --preset release --log-level=WARNING > /dev/null

setup:
	@tools/setup.sh
