// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "collinea/base/options.h"
#include "collinea/orient/instrument_options.h"
#include "collinea/project/project.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// How an oriented project is adjusted again.
struct AdjustProjectOptions {
  std::optional<Calibration> calibration;
  std::optional<AdditionalSet> additional;
  std::string additional_fixed;
  double additional_level = 0.01;
  bool refraction = false;
  Loss::Kind loss = Loss::kHuber;
  double loss_scale_sigmas = 2;
  bool use_positions = true;
  bool use_control = true;
  bool use_geodetic = true;
  InstrumentOptions instruments;
  /// The fields of `instruments` that count; for the others, it is as orient or the file had them.
  std::set<std::string, std::less<>> changed_instruments;
  bool given_sigmas = false;
  std::optional<bool> reject_mismatches;
  bool snoop = false;
  int snoop_most = 1000;
  bool variance_components = false;
  TestOptions tests;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = AdjustProjectOptions;
    visit(
        Field{"calibration", &O::calibration, "", "free camera parameters"}.or_auto("those of orient, or of the file"));
    visit(Field{"additional", &O::additional, "",
                "additional parameters of every camera, on top of its model, also of one that was given"}
              .or_auto("those it has"));
    visit(Field{"additional_fixed", &O::additional_fixed, "",
                "those of them that are fixed at zero, separated by commas: a3,a7"});
    visit(Field{"additional_level", &O::additional_level, "1",
                "chance that one that is zero is called significant; of 44 less than one is then", 1e-12, 0.5});
    visit(Field{"refraction", &O::refraction, "",
                "correct the measurements for the refraction of a standard atmosphere (high flights)"});
    visit(Field{"loss", &O::loss, "", "robust loss of tie points and positions"});
    visit(
        Field{"loss_scale_sigmas", &O::loss_scale_sigmas, "sigma", "residual from which the loss sets in", 0.01, 1e6});
    visit(Field{"use_positions", &O::use_positions, "", "use the positions of images where orient did"});
    visit(Field{"use_control", &O::use_control, "",
                "use control points where orient did; otherwise they are all check points"});
    visit(Field{"use_geodetic", &O::use_geodetic, "",
                "use what was measured between control points where orient did; otherwise it is only compared"});
    visit(
        Field{"given_sigmas", &O::given_sigmas, "",
              "take the sigmas of control and the coordinates of positions as they were given, also where orient found "
              "them contradicted"});
    visit(Field{"reject_mismatches", &O::reject_mismatches, "",
                "reject measurements of tie points that are more probably of another point than as imprecise as the "
                "others, all in one round"}
              .or_auto("of a project, not of a file"));
    visit(Field{"snoop", &O::snoop, "",
                "reject the worst suspect and adjust again, until none is left; measurements of control that orient "
                "rejected are tried again"});
    visit(Field{"snoop_most", &O::snoop_most, "1", "upper bound of what snooping rejects", 1, 1000000});
    visit(Field{"variance_components", &O::variance_components, "",
                "estimate the standard deviations of each group of observations, and use them"});
    visit(Part{&O::tests});
    visit(Group{"instruments", &O::instruments});
  }
};

}  // namespace collinea
