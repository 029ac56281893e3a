// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/edges_report.h"

#include <fmt/format.h>

namespace collinea {
namespace {

constexpr std::size_t kRows = 30;  // shown on a terminal

}  // namespace

std::string edges_text(const EdgesReport& report) {
  std::string text = fmt::format("{}: {} x {} px, noise of a grey value {:.2f}\n", report.image.string(), report.width,
                                 report.height, report.noise_grey);
  text += fmt::format("edges ({}) of {:.2f} grey values a pixel, followed down to {:.2f}: {} points in {} chains\n",
                      word_of(report.edge_operator), report.high, report.low, report.points, report.chains);
  text += fmt::format("errors of neighbours on an edge are correlated over {:.1f} px\n", 2 * report.along_px);
  text += fmt::format("{}: {}\n", word_of(report.find), report.found.rows.size());
  if (!report.found.rows.empty()) {
    TextTable shown = report.found;
    shown.remarks.clear();
    if (shown.rows.size() > kRows) shown.rows.resize(kRows);
    text += "\n" + text_of(shown);
    if (report.found.rows.size() > kRows)
      text += fmt::format("... and {} more in the table\n", report.found.rows.size() - kRows);
    text += "\n";
  }
  if (report.not_measured > 0)
    text +=
        fmt::format("weak: {} of the points given show no target of that kind and size: look at them in the image\n",
                    report.not_measured);
  if (report.scaled > 0)
    text += fmt::format(
        "note: residuals of {} of them are larger than the noise explains; their standard deviations are multiplied by "
        "sigma0\n",
        report.scaled);
  for (const auto& file : report.files) text += file.string() + "\n";
  return text;
}

}  // namespace collinea
