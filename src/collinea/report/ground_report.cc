// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/ground_report.h"

#include <fmt/format.h>

#include <numbers>

namespace collinea {
namespace {

std::string pair_line(const std::array<std::string, 2>& files, const StereoChoice& pair) {
  const std::string sigma = pair.sigma_height_m ? fmt::format("{:.3f}", *pair.sigma_height_m) : "-";
  return fmt::format("{} {}  base to height {:.2f}, convergence {:.1f} deg, sigma of the height {} m{}\n", files[0],
                     files[1], pair.base_to_height, pair.convergence_rad * 180 / std::numbers::pi, sigma,
                     pair.is_hidden ? ", hidden by the surface" : "");
}

}  // namespace

std::string ground_text(const GroundReport& report) {
  const Eigen::Vector3d& at = report.position;
  std::string text = fmt::format("position  {:.4f} {:.4f} {:.4f} m\n", at.x(), at.y(), at.z());
  text += report.sigma_m ? fmt::format("sigma     {:.4f} {:.4f} {:.4f} m\n", report.sigma_m->x(), report.sigma_m->y(),
                                       report.sigma_m->z())
                         : std::string("sigma     - (the poses have no covariance: run adjust)\n");
  text += fmt::format("parallax  {:.3f} px, sigma {:.3f} px, correlation {:.2f}\n", report.match.mark.parallax,
                      report.match.sigma_px, report.match.correlation);
  for (std::size_t k = 0; k < 2; ++k)
    text += fmt::format("pixel     {} {:.3f} {:.3f}\n", report.files[k], report.match.pixels[k].x(),
                        report.match.pixels[k].y());
  text += "pair      " + pair_line(report.files, report.pair);
  for (const GroundReport::Other& one : report.others) text += "shows it  " + pair_line(one.files, one.pair);
  return text;
}

}  // namespace collinea
