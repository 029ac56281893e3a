// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/rotation_report.h"

#include <fmt/format.h>

#include <cmath>

#include "collinea/report/single_step.h"

namespace collinea {
namespace {

std::string values_text(const RotationReport::Form& form) {
  std::string text;
  for (std::size_t i = 0; i < form.values.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    text += fmt::format("  {} {:.8f}", form.values[i].first, form.values[i].second);
    if (form.covariance.size()) text += fmt::format(" +- {}", sigma_text(std::sqrt(form.covariance(at, at))));
  }
  return text;
}

std::string correlation_text(const RotationReport::Form& form) {
  if (form.values.size() != 3 || !form.covariance.size()) return "";
  std::string text = "             correlations";
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 3; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      const double size = std::sqrt(form.covariance(a, a) * form.covariance(b, b));
      text += fmt::format("  {} and {} {}", form.values[i].first, form.values[j].first,
                          size > 0 ? fmt::format("{:+.3f}", form.covariance(a, b) / size) : "-");
    }
  return text + "\n";
}

}  // namespace

std::string rotation_text(const RotationReport& report) {
  std::string text = "matrix, image from object:\n";
  for (int i = 0; i < 3; ++i)
    text += fmt::format("  {:13.10f}  {:13.10f}  {:13.10f}\n", report.matrix(i, 0), report.matrix(i, 1),
                        report.matrix(i, 2));
  if (report.sigma_matrix) {
    text += "their standard deviations:\n";
    for (int i = 0; i < 3; ++i)
      text += fmt::format("  {:13.10f}  {:13.10f}  {:13.10f}\n", (*report.sigma_matrix)(i, 0),
                          (*report.sigma_matrix)(i, 1), (*report.sigma_matrix)(i, 2));
  }
  if (report.given_error > 1e-9)
    text += fmt::format("as given it was off a rotation by {:.1e}; this is the nearest one\n", report.given_error);
  text += fmt::format("angles in {}:\n", report.unit);
  for (const RotationReport::Form& form : report.forms) {
    text += fmt::format("  {:<11}", form.name);
    text += values_text(form);
    if (form.values.empty())
      text += "  none: the rotation is by half a circle";
    else if (form.is_singular)
      text += "  (singular: one angle is free, the last is set to 0)";
    text += "\n" + correlation_text(form);
  }
  return text;
}

}  // namespace collinea
