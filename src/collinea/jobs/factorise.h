// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/epipolar/image_bundles.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/factorisation_report.h"

namespace collinea {

struct FactoriseOptions {
  PhotoOptions photo;
  CalibrationUnknowns calibration = CalibrationUnknowns::kFocalPoint;
  std::optional<double> sigma = {};
  bool reject = false;
  double alpha = 0.001;
  std::uint64_t seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FactoriseOptions;
    visit(Part{&O::photo});
    visit(Field{"calibration", &O::calibration, "", "what of the camera is found from the measurements alone"});
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of a coordinate where the table states none, in its unit; nothing: 0.5 px or 0.005 "
                "mm, and sigma0 tells the true size",
                1e-9, 1e6});
    visit(Field{
        "reject", &O::reject, "",
        "leave out points of which a test is beyond its limit and half of the largest, and begin again, as long as "
        "there are any"});
    visit(Field{"alpha", &O::alpha, "1", "chance with which a test rejects what is right", 1e-6, 0.5});
    visit(Field{"seed", &O::seed, "", "of the samples of the calibrated path"});
  }
};

/// Cameras and points from nothing but the measurements of a table (image point x y, and sigma where it is known):
/// factorised() of the points that all images show, calibration from the fundamental matrices, Euclidean upgrade and
/// bundles with one unknown calibration (self_calibrated()); with a principal distance the calibrated path beside it.
/// In pixels a principal point of 0,0 stands for the middle of the measurements. Where there is no Euclidean form the
/// report says why. Errors: file, columns, and those of factorised().
[[nodiscard]] Result<FactorisationReport> factorise_table(const std::filesystem::path& measurements,
                                                          const FactoriseOptions& options);

}  // namespace collinea
