// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/html_page.h"

namespace collinea {

const char* const kStyleSheet = R"css(
:root { --ink: #17212f; --soft: #5b6778; --line: #d5dbe3; --wash: #f4f6f9; --blue: #1f5fa8; --red: #c2410c; --teal: #0b7a75; }
* { box-sizing: border-box; }
body { margin: 0; background: #fff; color: var(--ink); font: 15px/1.5 "Segoe UI", "Helvetica Neue", Arial, "Liberation Sans", sans-serif; }
main { max-width: 1000px; margin: 0 auto; padding: 32px 30px 60px; }
header { display: flex; justify-content: space-between; align-items: flex-end; border-bottom: 3px solid var(--ink); padding-bottom: 12px; }
h1 { font-size: 27px; line-height: 1.2; margin: 0; }
h2 { font-size: 19px; margin: 38px 0 10px; padding-bottom: 4px; border-bottom: 1px solid var(--line); break-after: avoid; }
h3 { font-size: 15px; margin: 18px 0 6px; break-after: avoid; }
p { margin: 6px 0 10px; max-width: 820px; }
header p { margin: 2px 0 0; color: var(--soft); text-align: right; }
.statement { margin: 22px 0 0; padding: 16px 20px; border-left: 6px solid var(--blue); background: var(--wash); break-inside: avoid; }
.statement.unverified { border-color: #b7791f; }
.statement p { font-size: 17px; margin: 0; max-width: none; }
.statement p.kind { font-size: 13px; color: var(--soft); margin: 12px 0 5px; }
.axes { display: flex; gap: 14px; flex-wrap: wrap; }
.axes div { flex: 1; min-width: 130px; background: #fff; border: 1px solid var(--line); padding: 8px 14px; }
.axes b { display: block; font-size: 22px; font-weight: 600; white-space: nowrap; }
.axes span, .facts dt { color: var(--soft); font-size: 13px; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(200px, 1fr)); gap: 2px 26px; margin: 22px 0 0; }
.facts div { border-bottom: 1px solid var(--line); padding: 5px 0; break-inside: avoid; }
.facts dd { margin: 0; font-weight: 600; }
.facts .wide { grid-column: span 2; }
ul.cautions { margin: 18px 0 0; padding: 10px 18px 10px 34px; background: #fdf6e7; border: 1px solid #ecd9ac; }
ul.cautions li { margin: 3px 0; }
figure { margin: 12px 0; break-inside: avoid; }
figcaption { color: var(--soft); font-size: 13px; max-width: 860px; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 20px; align-items: start; }
.pair > * { min-width: 0; }
svg, img { max-width: 100%; height: auto; display: block; }
.map svg { border: 1px solid var(--line); }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th { text-align: right; font-weight: 600; color: var(--soft); border-bottom: 1.5px solid var(--ink); padding: 4px 8px; vertical-align: bottom; }
td { text-align: right; border-bottom: 1px solid var(--line); padding: 3px 8px; vertical-align: top; }
th.l, td.l { text-align: left; }
td.l { overflow-wrap: break-word; }
td.l:first-child, td.w { overflow-wrap: anywhere; min-width: 10em; }
.table { overflow-x: auto; margin: 8px 0; }
.pairs th, .pairs td { text-align: left; }
.pairs td:first-child { width: 32%; color: var(--soft); }
tr { break-inside: avoid; }
thead { display: table-header-group; }
tr.total td { border-top: 1.5px solid var(--ink); font-weight: 600; }
td.bad { color: #b3261e; font-weight: 700; }
tr.out td { color: var(--soft); text-decoration: line-through; }
tr.out td.l { text-decoration: none; }
.meter { display: inline-block; width: 110px; height: 9px; background: var(--wash); vertical-align: middle; }
.meter i { display: block; height: 100%; background: #7d9cc4; }
.signed { break-inside: avoid; }
.signature { display: flex; gap: 30px; margin-top: 8px; }
.signature div { flex: 1; display: flex; flex-direction: column; justify-content: flex-end; min-height: 64px; font-weight: 600; }
.signature span { border-top: 1px solid var(--ink); padding-top: 3px; color: var(--soft); font-size: 13px; font-weight: 400; }
.hash { font-family: "Liberation Mono", "DejaVu Sans Mono", monospace; font-size: .92em; overflow-wrap: anywhere; }
footer { margin-top: 40px; border-top: 1px solid var(--line); padding-top: 8px; color: var(--soft); font-size: 12.5px; }
svg text { font: 12px "Segoe UI", "Helvetica Neue", Arial, "Liberation Sans", sans-serif; fill: var(--ink); }
svg .halo { paint-order: stroke; stroke: #fff; stroke-width: 3px; font-weight: 600; }
svg path, svg polyline, svg polygon { stroke-linejoin: round; }
.footprint { fill: #1f5fa8; fill-opacity: .05; stroke: #1f5fa8; stroke-opacity: .35; stroke-width: .8; }
.footprint.many { fill-opacity: .025; stroke-opacity: .16; }
.footprint.crowd { fill-opacity: .008; stroke-opacity: .05; }
.station { fill: #17212f; }
.lost { fill: none; stroke: #b3261e; stroke-width: 1.4; }
.control { fill: #fff; stroke: #c2410c; stroke-width: 2; }
.check { fill: #fff; stroke: #7a2fb0; stroke-width: 2; }
.unused { stroke: #9aa4b2; }
.dot { fill: #17212f; }
.plan_arrow { fill: none; stroke: #c2410c; stroke-width: 2.2; }
.height_arrow { fill: none; stroke: #0b7a75; stroke-width: 2.2; }
.pattern_arrow { fill: none; stroke: #1f5fa8; stroke-width: 1.3; }
.section { fill: none; stroke: #1f5fa8; stroke-width: 1.6; }
.section.two { stroke: #c2410c; }
.section.three { stroke: #0b7a75; }
.section.four { stroke: #7a2fb0; }
.band { fill: #1f5fa8; fill-opacity: .15; stroke: none; }
.band.two { fill: #c2410c; }
.band.three { fill: #0b7a75; }
.band.four { fill: #7a2fb0; }
.site { fill: #e9efe4; stroke: #6b8f4e; stroke-width: 1.4; fill-opacity: .35; }
.site.outline { fill: none; }
.flight { fill: none; stroke: #1f5fa8; stroke-opacity: .5; stroke-width: 1; }
.flight.cross { stroke: #7a2fb0; }
.ellipse { fill: #c2410c; fill-opacity: .12; stroke: #c2410c; stroke-width: 1.2; }
.ellipse.tie { fill: #1f5fa8; stroke: #1f5fa8; }
.ellipse.checked { fill: #7a2fb0; stroke: #7a2fb0; }
.height_bar { fill: none; stroke: #0b7a75; stroke-width: 1.6; }
.more { fill: none; stroke: #b3261e; stroke-width: 2; stroke-dasharray: 3 2; }
.scale { fill: none; stroke: #17212f; stroke-width: 2; }
.needle { fill: #17212f; }
.paper { fill: #fff; fill-opacity: .82; }
.grid { stroke: #e4e8ee; stroke-width: 1; }
.axis { stroke: #5b6778; stroke-width: 1; }
.frame { fill: none; stroke: #5b6778; stroke-width: 1; }
.bar { fill: #7d9cc4; }
.curve { fill: none; stroke: #1f5fa8; stroke-width: 2; }
.curve.second { stroke: #c2410c; stroke-width: 1.6; stroke-dasharray: 6 4; }
@media (max-width: 700px) {
  main { padding: 20px 14px 40px; }
  header { display: block; }
  header p { text-align: left; }
  h1, h2, h3, p, li, dd, figcaption { overflow-wrap: anywhere; }
  .pair { grid-template-columns: 1fr; }
  .facts { grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); }
  .facts .wide { grid-column: 1 / -1; }
  .signature { display: block; }
  .meter { width: 50px; }
  .map { overflow-x: auto; }
  .map svg { min-width: 560px; max-width: none; }
  .pair .map svg { min-width: 0; max-width: 100%; }
}
@page {
  size: A4;
  margin: 15mm 14mm 18mm;
  @bottom-left { color: #5b6778; font: 8pt "Liberation Sans", Arial, sans-serif; }
  @bottom-right { content: counter(page) " / " counter(pages); color: #5b6778; font: 8pt "Liberation Sans", Arial, sans-serif; }
}
@page wide { size: A4 landscape; }
@media print {
  body { font-size: 10.5pt; }
  main { padding: 0; max-width: none; }
  h1, h2, h3, p, li, dd { overflow-wrap: anywhere; }
  p, li { orphans: 3; widows: 3; }
  .table { overflow: visible; }
  table { font-size: 8.8pt; }
  .many table { font-size: 7pt; }
  .many th, .many td { padding: 2px 3px; }
  .many td.l:first-child { min-width: 8em; }
  .crowd { page: wide; }
  .crowd table { font-size: 4.2pt; }
  .crowd th, .crowd td, .crowd td.l:first-child { padding: 1px; min-width: 0; }
  figure > svg, figure > img { max-height: 118mm; }
  section > svg { max-height: 80mm; width: auto; }
  p + .table { break-before: avoid; }
  .pair figure > svg, .pair figure > img { max-height: 62mm; width: auto; }
  figure, .pair, ul.cautions li { break-inside: avoid; }
  figcaption, .facts dt { font-size: 8.5pt; }
  .facts { grid-template-columns: repeat(4, 1fr); gap: 0 18px; font-size: 9.5pt; }
  .facts .wide { grid-column: span 2; }
  .pair { grid-template-columns: 1fr 1fr; }
  h2 { margin-top: 22px; }
  .meter { width: 56px; }
  table.whole { break-inside: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)css";

}  // namespace collinea
