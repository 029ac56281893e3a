#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what collinea is built with and runs on, from Debian 12's own packages. Does nothing where all is there.
# PACKAGES: further ones. A developer also wants clang-format.
set -eu

packages="${PACKAGES:-}
g++ cmake ninja-build pkg-config ccache python3
libeigen3-dev libhwy-dev libfmt-dev libexpected-dev libcli11-dev nlohmann-json3-dev
libgdal-dev libproj-dev proj-data libexiv2-dev libjpeg62-turbo-dev libpng-dev libtiff-dev libsqlite3-dev libssl-dev libboost-dev libhpdf-dev
libgtest-dev
"

# The page of `collinea serve` is built with nodejs and npm; newer ones than Debian's, from elsewhere, will do.
node_major=$(node --version 2>/dev/null | sed 's/^v\([0-9]*\).*/\1/' || true)
if [ "${node_major:-0}" -lt 18 ] || ! command -v npm >/dev/null; then packages="$packages nodejs npm"; fi

missing=""
for package in $packages; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q "ok installed" || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

echo "== installing:$missing"
sudo=""
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "not root and no sudo: install these packages first:$missing" >&2; exit 1; }
  sudo=sudo
fi
$sudo apt-get update -qq
# shellcheck disable=SC2086
DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends $missing
