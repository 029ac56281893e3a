// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/report/internal/figures.h"
#include "collinea/report/internal/html_page.h"
#include "collinea/report/internal/summary.h"

namespace collinea {

/// What is shown of surface and orthophoto, of the map or of a plane; what is missing is left out.
struct ProductPreviews {
  std::optional<Preview> heights, ortho;
};

/// The whole page. `frames`: of the planes in the record of the step frames, in its order.
[[nodiscard]] std::string report_page(const ReportInput& input, const ReportSummary& summary,
                                      const ProductPreviews& map, const std::vector<ProductPreviews>& frames);

// Its parts, each one or more <section>; empty when there is nothing to tell.
[[nodiscard]] std::string control_section(const ReportInput& input, const ReportSummary& summary);
[[nodiscard]] std::string geodetic_section(const ReportInput& input);
[[nodiscard]] std::string position_section(const ReportInput& input, const ReportSummary& summary);
[[nodiscard]] std::string camera_section(const ReportInput& input, const ReportSummary& summary);
[[nodiscard]] std::string film_section(const ReportInput& input);
[[nodiscard]] std::string image_section(const ReportInput& input, const ReportSummary& summary);
[[nodiscard]] std::string left_out_section(const ReportInput& input, const ReportSummary& summary);
[[nodiscard]] std::string process_section(const ReportInput& input);
[[nodiscard]] std::string signature_section(const ReportInput& input);

}  // namespace collinea
