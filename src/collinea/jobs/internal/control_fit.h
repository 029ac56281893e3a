// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/geometry/absolute_orientation.h"
#include "collinea/geometry/closed_orientation.h"
#include "collinea/report/absolute_report.h"

namespace collinea {

/// Points known in a model and on the ground, and what becomes of them.
struct ControlFit {
  std::vector<std::string> names;
  std::vector<AbsoluteControl> pairs;
  std::vector<bool> is_check;                       ///< only compared
  std::vector<bool> is_rejected;                    ///< contradicts the others
  std::optional<Eigen::MatrixXd> model_covariance;  ///< of the model coordinates of all, in place of those of the pairs
  bool sigmas_are_stated = true;
  std::optional<ClosedForm> closed_form;  ///< by which it is found; nothing: least squares

  [[nodiscard]] std::vector<std::size_t> used() const;
  [[nodiscard]] std::vector<AbsoluteControl> used_pairs() const;
};

/// The orientation by what is used. Errors: as absolute_orientation(); no closed form.
[[nodiscard]] Result<AbsoluteOrientation> fitted(const ControlFit& control);
/// With `reject` again without the point of the largest test as long as that is beyond its limit and enough is left.
[[nodiscard]] Result<AbsoluteOrientation> fitted_with_rejection(ControlFit& control, bool reject, double alpha);

/// Parameters, tests and roles of the points; without `ground`.
[[nodiscard]] AbsoluteReport control_report(const ControlFit& control, const AbsoluteOrientation& found,
                                            const VarianceTest& variance);

}  // namespace collinea
