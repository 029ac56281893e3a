#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Renders a survey with known truth, makes its map, and says in six lines what came out and how good it is.
# usage: demo.sh [FOLDER]      (default: demo). COLLINEA: the program (default: the one in the PATH)
set -eu
collinea=${COLLINEA:-collinea}
out=${1:-demo}
started=$(date +%s)

since() {
  seconds=$(($(date +%s) - started))
  printf '%d:%02d' $((seconds / 60)) $((seconds % 60))
}

echo "== rendering 24 photographs of a made-up landscape, in $out/block"
[ -e "$out/block/control.csv" ] || "$collinea" simulate "$out/block"
echo "== from photographs to map, in $out/project ($(since) gone)"
"$collinea" run "$out/block/images" -o "$out/project" --control "$out/block/control.csv"
echo "== comparing with the truth ($(since) gone)"
"$collinea" assess "$out/project" "$out/block/truth" > "$out/assessment.txt"

# Numbers of the line of the assessment that begins as said: the one after a word, and the first.
figure() { sed -n "s/^$1  .*$2 *\([-+0-9.]*\).*/\1/p" "$out/assessment.txt" | head -1; }
first() { sed -n "s/^$1  *\([0-9.]*\).*/\1/p" "$out/assessment.txt" | head -1; }
centimetres() { awk -v metres="$1" 'BEGIN { printf "%.1f cm", 100 * metres }'; }
images=$(sed -n 's/^images oriented *\(.*\)/\1/p' "$out/assessment.txt")
echo
echo "Made in $(since): point cloud, surface and terrain models, contours and an orthophoto from $images photographs."
echo "Position: $(first 'check points') points that took no part are off by $(centimetres "$(figure 'check points' 3D)") (root mean square, in space); a pixel is 5 cm."
echo "Heights: the surface model is off by $(centimetres "$(figure 'surface model, smooth ground' NMAD)") on open ground, and covers $(first 'surface model, completeness') % of what was photographed."
echo "Orthophoto: shifted by $(figure 'orthophoto, local shift' median) pixels (median over the map)."
echo "Look at it: $collinea serve $out/project --open, or xdg-open $out/project/report/report.html; products: $out/project/products (QGIS, CloudCompare)."
echo "All figures: $out/assessment.txt, made by collinea assess. Your own photographs: collinea run PHOTOS -o PROJECT"
