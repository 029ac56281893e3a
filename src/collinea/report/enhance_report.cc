// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/enhance_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kPlotWidth = 420, kPlotHeight = 280;

double share_of(const GreyHistogram& histogram, std::size_t grey) {
  const auto all = static_cast<double>(std::max<std::uint64_t>(1, histogram.total()));
  return static_cast<double>(histogram.count[grey]) / all;
}

// Bars as the outline of an area, and the cumulative curve; the highest bar takes the height, but the two ends, where
// what was cut is heaped up, may be cut off.
void draw_histogram(Svg& svg, const EnhanceStep& step, double left, const std::string& title) {
  double highest = 0;
  for (std::size_t g = 1; g + 1 < kGreyValues; ++g) highest = std::max(highest, share_of(step.histogram, g));
  if (!(highest > 0)) highest = std::max(share_of(step.histogram, 0), share_of(step.histogram, kGreyValues - 1));
  if (!(highest > 0)) highest = 1;
  const Axis x{0, kGreyValues, left + 62, left + kPlotWidth - 12};
  const Axis y{0, 110 * highest, kPlotHeight - 46, 30}, whole{0, 1.1, kPlotHeight - 46, 30};
  draw_axes(svg, x, y, "grey value", "pixels [%]");
  svg.text({left + 62, 18}, title);
  std::vector<Vector2d> curve = {{x(0), whole(0)}};
  for (std::size_t g = 0; g < kGreyValues; ++g) {
    const double top = y(100 * std::min(1.1 * highest, share_of(step.histogram, g)));
    const double at = x(static_cast<double>(g)), next = x(static_cast<double>(g + 1));
    if (step.histogram.count[g] > 0) svg.rectangle(at, top, next - at, y(0) - top, "bar");
    curve.emplace_back(next, whole(step.histogram.share_up_to(static_cast<int>(g))));
  }
  svg.path(curve, "sum");
}

}  // namespace

TextTable grey_statistics_table(const EnhanceReport& report) {
  TextTable table;
  table.remarks = {fmt::format("{}: grey values after each step, all channels together", report.image),
                   "contrast: standard deviation; black, white: share of pixels at 0 and 255"};
  table.columns = {{"step", ""}, {"width", "px"}, {"height", "px"}};
  for (const char* name : {"least", "q05", "median", "q95", "largest", "mean", "contrast"})
    table.columns.push_back({name, "grey"});
  for (const char* name : {"entropy_bit", "black", "white"}) table.columns.push_back({name, ""});
  for (const EnhanceStep& step : report.steps) {
    const GreyStatistics s = statistics_of(step.histogram);
    const GreyHistogram& h = step.histogram;
    table.rows.push_back({step.name, std::to_string(step.width), std::to_string(step.height), std::to_string(s.least),
                          std::to_string(h.quantile(0.05)), std::to_string(h.quantile(0.5)),
                          std::to_string(h.quantile(0.95)), std::to_string(s.most), fmt::format("{:.2f}", s.mean),
                          fmt::format("{:.2f}", s.contrast), fmt::format("{:.3f}", s.entropy_bit),
                          fmt::format("{:.4f}", share_of(h, 0)), fmt::format("{:.4f}", share_of(h, kGreyValues - 1))});
  }
  return table;
}

TextTable histogram_table(const EnhanceReport& report) {
  TextTable table;
  table.remarks = {fmt::format("{}: pixels of each grey value, and share of those up to it", report.image)};
  table.columns = {{"value", "grey"}, {"before", ""}, {"before_up_to", ""}, {"after", ""}, {"after_up_to", ""}};
  if (!report.table.empty()) table.columns.push_back({"becomes", "grey"});
  const GreyHistogram &before = report.steps.front().histogram, &after = report.steps.back().histogram;
  for (std::size_t g = 0; g < kGreyValues; ++g) {
    table.rows.push_back({std::to_string(g), std::to_string(before.count[g]),
                          fmt::format("{:.6f}", before.share_up_to(static_cast<int>(g))),
                          std::to_string(after.count[g]),
                          fmt::format("{:.6f}", after.share_up_to(static_cast<int>(g)))});
    if (!report.table.empty()) table.rows.back().push_back(std::to_string(report.table.front()[g]));
  }
  return table;
}

std::string histogram_svg(const EnhanceReport& report) {
  Svg svg(2 * kPlotWidth, kPlotHeight, "Histogram before and after");
  draw_histogram(svg, report.steps.front(), 0, "before");
  draw_histogram(svg, report.steps.back(), kPlotWidth, "after");
  std::string text = svg.finish();
  text.insert(
      text.find('\n') + 1,
      "<style>text{font:12px sans-serif;fill:#17212f}.grid{stroke:#e4e8ee;stroke-width:1}.frame{fill:none;stroke:"
      "#5b6778}.bar{fill:#5b6778}.sum{fill:none;stroke:#c2410c;stroke-width:1.6}</style>\n<rect width=\"100%\" "
      "height=\"100%\" fill=\"#fff\"/>\n");
  text.insert(text.find("<svg") + 4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return text;
}

std::string enhance_text(const EnhanceReport& report) {
  const EnhanceStep &first = report.steps.front(), &last = report.steps.back();
  std::string text = fmt::format("{}: {} x {} px, {}", report.image, first.width, first.height,
                                 report.channels == 1 ? "grey" : "colour");
  if (last.width != first.width || last.height != first.height)
    text += fmt::format("; result {} x {} px", last.width, last.height);
  text += "\n";
  if (report.empty_share > 0)
    text +=
        fmt::format("{:.1f} % of the pixels are empty: they count nowhere, and stay empty\n", 100 * report.empty_share);
  if (report.black) text += fmt::format("stretch: {} becomes black, {} white\n", *report.black, *report.white);
  if (report.threshold)
    text += fmt::format("threshold: white from grey value {} on{}\n", *report.threshold,
                        report.is_threshold_found ? " (found: two classes that differ most)" : "");
  TextTable table = grey_statistics_table(report);
  table.remarks.clear();
  return text + "\n" + text_of(table);
}

}  // namespace collinea
