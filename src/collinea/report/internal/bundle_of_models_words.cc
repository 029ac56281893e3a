// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/bundle_of_models_words.h"

#include <fmt/format.h>

#include <cmath>

namespace collinea {
namespace {

using Eigen::Vector3d;

std::string number(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

}  // namespace

std::string bundle_text(const JoinedBlock& models, const BundleOfModels& bundle) {
  const BundleComparison found = compare(models, bundle);
  return fmt::format(
      "bundle        of the same measurements: {} observations, {} unknowns, redundancy {}, sigma0 {}\n"
      "              models differ by X {:.4g}, Y {:.4g}, Z {:.4g} m (RMS of {} points), {:.2f}, {:.2f}, {:.2f} of its "
      "sigmas;\n              their sigmas are {:.2f}, {:.2f}, {:.2f} of these\n",
      bundle.observations, bundle.unknowns, bundle.redundancy, number(bundle.sigma0, "{:.4g}"), found.apart.x(),
      found.apart.y(), found.apart.z(), found.points, found.apart_in_sigmas.x(), found.apart_in_sigmas.y(),
      found.apart_in_sigmas.z(), found.ratio.x(), found.ratio.y(), found.ratio.z());
}

void add_bundle_columns(TextTable& table) {
  for (const char* name : {"bundle_X", "bundle_Y", "bundle_Z", "bundle_sigma_X", "bundle_sigma_Y", "bundle_sigma_Z",
                           "less_bundle_X", "less_bundle_Y", "less_bundle_Z"})
    table.columns.push_back({name, "m"});
  for (const char* name : {"sigma_ratio_X", "sigma_ratio_Y", "sigma_ratio_Z"}) table.columns.push_back({name, ""});
}

void add_bundle_fields(const JoinedPoint& point, const BundleOfModels& bundle, std::vector<std::string>& row) {
  const auto other = bundle.points.find(point.name);
  if (other == bundle.points.end()) {
    row.insert(row.end(), 12, "-");
    return;
  }
  const Vector3d sigma = other->second.covariance.diagonal().cwiseMax(0).cwiseSqrt(),
                 own = point.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  for (int axis = 0; axis < 3; ++axis) row.push_back(number(other->second.position[axis], "{:.5f}"));
  for (int axis = 0; axis < 3; ++axis) row.push_back(number(sigma[axis], "{:.3g}"));
  for (int axis = 0; axis < 3; ++axis)
    row.push_back(number(point.position[axis] - other->second.position[axis], "{:.5f}"));
  for (int axis = 0; axis < 3; ++axis) row.push_back(number(own[axis] / sigma[axis], "{:.3f}"));
}

}  // namespace collinea
