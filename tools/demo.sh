#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Renders the demo block, runs the main job on it and says how far the products are from the known truth.
set -eu
cd "$(dirname "$0")/.."
collinea=build/release/bin/collinea
out=${1:-demo}

echo "== rendering the demo block in $out/block"
[ -e "$out/block/control.csv" ] || $collinea simulate "$out/block"
echo "== photographs to map in $out/project"
$collinea run "$out/block/images" -o "$out/project" --control "$out/block/control.csv"
echo "== against the known truth"
$collinea assess "$out/project" "$out/block/truth"
echo
echo "report:       $out/project/report/report.html"
echo "point cloud:  $out/project/products/cloud.las"
echo "surface:      $out/project/products/dsm.tif"
echo "orthophoto:   $out/project/products/ortho.tif"
