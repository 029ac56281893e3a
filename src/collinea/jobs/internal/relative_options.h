// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/io/photo_frame.h"

namespace collinea {

struct RelativePairOptions {
  PhotoOptions photo;
  RelativeOptions adjustment;
  std::optional<double> sigma = {};
  bool estimate_sigma = false;
  std::optional<double> base_m = {};
  std::optional<std::filesystem::path> distances = {};
  std::optional<std::string> given = {};
  std::optional<std::filesystem::path> given_correlations = {};
  std::uint64_t seed = 1;
  std::optional<std::filesystem::path> out = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RelativePairOptions;
    visit(Part{&O::photo});
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of a coordinate where the table gives none, in its unit; nothing: found from the "
                "residuals",
                1e-9, 1e6});
    visit(Field{"estimate_sigma", &O::estimate_sigma, "",
                "multiply standard deviations by sigma0, even where they are given"});
    visit(Part{&O::adjustment});
    visit(Field{"base_m", &O::base_m, "m", "length of the base; nothing: model coordinates are in units of the base",
                1e-9, 1e9});
    visit(Field{"distances", &O::distances, "",
                "table of distances measured between points: from to distance[m] sigma[m]; they give the base"}
              .leads_to(PathKind::kFile));
    visit(
        Field{"given", &O::given, "",
              "an orientation that is given: nothing is solved, it is converted between its forms, and the points are "
              "compared with it. A table of exterior orientations of both images (as exterior.txt), one of elements "
              "(as parameters.txt), dependent:by,bz,omega,phi,kappa or symmetric:phi1,kappa1,omega2,phi2,kappa2 in "
              "degrees, with five standard deviations behind them where they are known"});
    visit(Field{"given_correlations", &O::given_correlations, "",
                "table of correlations of given elements (as correlations.txt); nothing: 0"}
              .leads_to(PathKind::kFile));
    visit(Field{"seed", &O::seed, "", "of the samples of the robust start: same seed, same result"});
    visit(Field{"out", &O::out, "",
                "folder for the tables (parameters, residuals, model coordinates, exterior orientation) and the "
                "picture of the pair's geometry"}
              .leads_to(PathKind::kFolder));
  }
};

}  // namespace collinea
