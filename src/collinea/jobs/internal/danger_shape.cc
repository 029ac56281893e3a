// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/danger_shape.h"

#include "collinea/base/file.h"
#include "collinea/jobs/internal/image_findings.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/report/findings_text.h"

namespace collinea {

void set_danger_cylinder(std::vector<ResectionReport::Image::Control> control, const Eigen::Vector3d& centre,
                         ResectionReport::Image& image) {
  std::vector<Eigen::Vector3d> points;
  for (const auto& one : control) points.push_back(one.position);
  image.danger = danger_cylinder(points, centre);
  image.control = std::move(control);
  image.station = centre;
}

Error with_danger(Error error, const ResectionReport& report, const ResectOneOptions& options) {
  const std::vector<Finding> findings = danger_findings(report);
  if (findings.empty()) return error;
  if (options.out) {
    const auto written = make_out_folder(*options.out).and_then([&] {
      return write_file(*options.out / "danger.svg", danger_svg(report));
    });
    if (!written) return written.error();
  }
  return std::move(error).advising("\n" + findings_text(findings));
}

}  // namespace collinea
