// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"

namespace collinea {

/// By what the similarity between model and ground is found.
enum class AbsoluteMethod : std::uint8_t { kLeastSquares, kUmeyama, kQuaternion, kRodrigues, kPlane };
inline constexpr Word<AbsoluteMethod> kAbsoluteMethodWords[] = {
    {AbsoluteMethod::kLeastSquares, "least_squares", "seven parameters with covariances, both sides with errors"},
    {AbsoluteMethod::kUmeyama, "umeyama", "closed form by singular values, covariances by propagation"},
    {AbsoluteMethod::kQuaternion, "quaternion", "closed form by the largest eigenvalue (Sanso, Horn)"},
    {AbsoluteMethod::kRodrigues, "rodrigues", "linear equations in Rodrigues' parameters"},
    {AbsoluteMethod::kPlane, "plane", "four parameters in X and Y, and their inverse"}};
[[nodiscard]] constexpr std::span<const Word<AbsoluteMethod>> words(AbsoluteMethod) { return kAbsoluteMethodWords; }

struct OrientAbsoluteOptions {
  AbsoluteMethod method = AbsoluteMethod::kLeastSquares;
  std::optional<double> sigma_model, sigma_ground;
  std::optional<std::filesystem::path> model_covariance;
  std::string check;
  bool least_median = false, reject = false;
  double alpha = 0.001;
  std::uint64_t seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = OrientAbsoluteOptions;
    visit(Field{"method", &O::method, "", "by what it is found"});
    visit(Field{"sigma_model", &O::sigma_model, "",
                "standard deviation of a model coordinate that states none, in the unit of the model; nothing: 0", 0,
                1e9});
    visit(Field{"sigma_ground", &O::sigma_ground, "m",
                "the same of a ground coordinate; nothing: 0, or where no table states any 0.01 m for all, of which "
                "sigma0 tells the true size",
                0, 1e6});
    visit(Field{"model_covariance", &O::model_covariance, "",
                "table with point_1, axis_1 (U, V or W), point_2, axis_2, covariance: of all model coordinates "
                "together, in the unit of the model squared, in place of the sigmas; each pair once"}
              .leads_to(PathKind::kFile));
    visit(Field{"check", &O::check, "", "names of points with commas between that are only compared"});
    visit(Field{"least_median", &O::least_median, "",
                "leave out control that the least median of squares over triples (in the plane pairs) contradicts"});
    visit(Field{"reject", &O::reject, "",
                "leave out control one by one as long as the largest test w of a coordinate is beyond its limit"});
    visit(Field{"alpha", &O::alpha, "1", "chance with which a test rejects what is right", 1e-6, 0.5});
    visit(Field{"seed", &O::seed, "", "of the triples drawn where there are many"});
  }
};

}  // namespace collinea
