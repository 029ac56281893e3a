// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/rotation_report.h"

#include <fmt/format.h>

namespace collinea {

std::string rotation_text(const RotationReport& report) {
  std::string text = "matrix, image from object:\n";
  for (int i = 0; i < 3; ++i)
    text += fmt::format("  {:13.10f}  {:13.10f}  {:13.10f}\n", report.matrix(i, 0), report.matrix(i, 1),
                        report.matrix(i, 2));
  if (report.given_error > 1e-9)
    text += fmt::format("as given it was off a rotation by {:.1e}; this is the nearest one\n", report.given_error);
  text += fmt::format("angles in {}:\n", report.unit);
  for (const RotationReport::Form& form : report.forms) {
    text += fmt::format("  {:<11}", form.name);
    for (const auto& [name, value] : form.values) text += fmt::format("  {} {:.8f}", name, value);
    if (form.values.empty())
      text += "  none: the rotation is by half a circle";
    else if (form.is_singular)
      text += "  (singular: one angle is free, the last is set to 0)";
    text += "\n";
  }
  return text;
}

}  // namespace collinea
