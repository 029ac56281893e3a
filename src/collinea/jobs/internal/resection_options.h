// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/io/photo_frame.h"

namespace collinea {

enum class ResectionMethod : std::uint8_t { kCollinearity, kLinear, kDlt, kPlane, kStation };
inline constexpr Word<ResectionMethod> kResectionMethodWords[] = {
    {ResectionMethod::kCollinearity, "collinearity", "all images at once by least squares, from P3P"},
    {ResectionMethod::kLinear, "linear",
     "one image by linear equations, without start: six points, or four of a plane"},
    {ResectionMethod::kDlt, "dlt", "direct linear transformation, 11 parameters, of points in space"},
    {ResectionMethod::kPlane, "plane", "the same of a plane, 8 parameters"},
    {ResectionMethod::kStation, "station", "from directions in the plane (Snellius, Pothenot)"}};
[[nodiscard]] constexpr std::span<const Word<ResectionMethod>> words(ResectionMethod) { return kResectionMethodWords; }

struct ResectOneOptions {
  PhotoOptions photo;
  ResectionMethod method = ResectionMethod::kCollinearity;
  std::optional<double> sigma, sigma_ground;
  std::optional<std::string> near;
  bool least_median = false, reject = false;
  double alpha = 0.001;
  std::uint64_t seed = 1;
  std::optional<std::filesystem::path> out = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ResectOneOptions;
    visit(Part{&O::photo});
    visit(Field{"method", &O::method, "", "by what the pose is found"});
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of an image coordinate that states none, in the unit of the table (px, mm; of "
                "directions deg or gon); nothing: 1 px, 0.01 mm, 0.001 deg, and sigma0 tells the true size",
                1e-12, 1e6});
    visit(Field{"sigma_ground", &O::sigma_ground, "m", "of a ground coordinate that states none; nothing: 0", 0, 1e6});
    visit(Field{"near", &O::near, "",
                "X,Y,Z of an approximate projection centre, where three points leave several poses"});
    visit(Field{"least_median", &O::least_median, "",
                "leave out points that the least median of squares over minimal samples contradicts"});
    visit(Field{"reject", &O::reject, "",
                "leave out measurements one by one as long as the largest test w is beyond its limit"});
    visit(Field{"alpha", &O::alpha, "1", "chance with which a test rejects what is right", 1e-6, 0.5});
    visit(Field{"seed", &O::seed, "", "of the samples drawn where there are many"});
    visit(Field{"out", &O::out, "",
                "folder for the tables of orientation, correlations, residuals and points, and the picture of the "
                "danger circle or cylinder"}
              .leads_to(PathKind::kFolder));
  }
};

}  // namespace collinea
