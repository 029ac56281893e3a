// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/intersection_report.h"

namespace collinea {

struct IntersectTableOptions {
  PhotoOptions photo;
  std::optional<double> sigma;
  std::optional<std::filesystem::path> ground;
  double alpha = 0.001;
  std::optional<std::filesystem::path> images;
  MultiImageOptions matching;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = IntersectTableOptions;
    visit(Part{&O::photo});
    visit(
        Field{"sigma", &O::sigma, "",
              "standard deviation of an image coordinate that states none, in the unit of the table; nothing: 1 px or "
              "0.01 mm, and sigma0 tells the true size",
              1e-12, 1e6});
    visit(Field{"ground", &O::ground, "", "table with point, X, Y, Z of points to compare with"}.leads_to(
        PathKind::kFile));
    visit(Field{"alpha", &O::alpha, "1", "chance with which a test rejects what is right", 1e-6, 0.5});
    visit(Field{"images", &O::images, "",
                "folder with the image files, named as in the tables: every point, as the image of its first "
                "measurement shows it, is matched in all of them at once, all rays meeting"}
              .leads_to(PathKind::kFolder));
    visit(Group{"matching", &O::matching});
  }
};

/// The points of a table of measurements (image, point, x, y, sigma) by the exterior orientations of another (image, X,
/// Y, Z, omega, phi, kappa, with sigma_ columns where known, and correlation_X_Y to correlation_phi_kappa). All images
/// are of one camera. With `images` the points are matched in the pixels, too. Errors: tables, options, images.
[[nodiscard]] Result<IntersectionReport> intersect_from_tables(const std::filesystem::path& measurements,
                                                               const std::filesystem::path& orientation,
                                                               const IntersectTableOptions& options,
                                                               const Run& run = {});

}  // namespace collinea
