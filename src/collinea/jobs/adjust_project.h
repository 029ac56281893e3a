// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/orient/instrument_options.h"
#include "collinea/project/project.h"

namespace collinea {

/// How an oriented project is adjusted again.
struct AdjustProjectOptions {
  std::string calibration = "auto";
  std::string additional = "auto";
  std::string additional_held;
  double additional_level = 0.01;
  bool refraction = false;
  std::string loss = "huber";
  double loss_scale_sigmas = 2;
  bool use_positions = true;
  bool use_control = true;
  bool use_ground = true;
  /// Changes what orient, or the file, took of instruments; nothing: as they did.
  std::function<void(InstrumentOptions&)> instruments;
  bool given_sigmas = false;
  bool snoop = false;
  int snoop_most = 1000;
  bool variance_components = false;
  double false_alarm = 0.001;
  double power = 0.8;
  bool sigma0_known = false;
  int folds = 5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = AdjustProjectOptions;
    visit(Field{"calibration", &O::calibration, "",
                "free camera parameters: auto (those of orient, or of the file) | none | focal | focal_radial | brown "
                "| brown_affinity"});
    visit(Field{
        "additional", &O::additional, "",
        "additional parameters of every camera, on top of its model, also of one that was given: auto (those it has) | "
        "none | polynomial | ebner | gruen | fourier"});
    visit(Field{"additional_held", &O::additional_held, "",
                "those of them that are held at zero, separated by commas: a3,a7"});
    visit(Field{"additional_level", &O::additional_level, "1",
                "chance that one that is zero is called significant; of 44 less than one is then", 1e-12, 0.5});
    visit(Field{"refraction", &O::refraction, "",
                "correct the measurements for the refraction of a standard atmosphere (high flights)"});
    visit(Field{"loss", &O::loss, "", "robust loss of tie points and positions: none | huber | cauchy"});
    visit(
        Field{"loss_scale_sigmas", &O::loss_scale_sigmas, "sigma", "residual from which the loss sets in", 0.01, 1e6});
    visit(Field{"use_positions", &O::use_positions, "", "use the positions of images where orient did"});
    visit(Field{"use_control", &O::use_control, "",
                "use control points where orient did; otherwise they are all check points"});
    visit(Field{"use_ground", &O::use_ground, "",
                "use what was measured between control points where orient did; otherwise it is only compared"});
    visit(Field{"given_sigmas", &O::given_sigmas, "",
                "take the sigmas of control and the places of positions as they were given, also where orient found "
                "them contradicted"});
    visit(Field{"snoop", &O::snoop, "",
                "take out the worst suspect and adjust again, until none is left; measurements of control that orient "
                "took out are tried again"});
    visit(Field{"snoop_most", &O::snoop_most, "1", "upper bound of what snooping takes out", 1, 1000000});
    visit(Field{"variance_components", &O::variance_components, "",
                "estimate the standard deviations of each group of observations, and use them"});
    visit(Field{"false_alarm", &O::false_alarm, "1", "probability that the test of a good observation says blunder",
                1e-12, 0.5});
    visit(Field{"power", &O::power, "1", "probability with which a minimal detectable blunder is found", 0.5, 0.999});
    visit(Field{"sigma0_known", &O::sigma0_known, "",
                "the given sigmas are true: test by Baarda's w; otherwise by Pope's tau"});
    visit(Field{"folds", &O::folds, "1",
                "parts of the control, each left out together and foretold by the others; fewer where a part would "
                "have one point",
                2, 100});
  }
};

/// Adjusts the oriented block of a project once more and writes report and tables to PROJECT/adjustment. The project
/// itself stays as it is. Answers a line for the user. Errors: not oriented yet; those of adjust().
[[nodiscard]] Result<std::string> adjust_project(const Project& project, const AdjustProjectOptions& options);

/// Writes what adjust_project would adjust, as a text file that adjust_file reads. Errors: not oriented yet, disk.
Result<> export_adjustment(const Project& project, const AdjustProjectOptions& options,
                           const std::filesystem::path& file);

/// Adjusts measurements without a project: finds approximate values that are missing, and writes to `folder` what
/// adjust_project writes. A named set of free parameters takes the place of what the file says, but for the standard
/// deviations of those it frees. Errors: the file's, with its name and line; nothing to begin at; those of adjust().
[[nodiscard]] Result<std::string> adjust_file(const std::filesystem::path& file, const std::filesystem::path& folder,
                                              const AdjustProjectOptions& options, const Run& run);

/// The file in our own format, whatever it was in: "converted".
Result<> convert_adjustment(const std::filesystem::path& file, const std::filesystem::path& converted);

}  // namespace collinea
