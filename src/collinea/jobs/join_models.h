// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/report/models_report.h"

namespace collinea {

/// How independent models are joined.
struct JoinModelsOptions {
  std::optional<std::filesystem::path> control = {}, covariances = {}, pairs = {};
  std::optional<double> sigma = {};
  double control_sigma_m = 0;
  bool estimate_sigma = false;
  bool anblock = false;
  bool bundle = false;
  bool chain_only = false;
  double false_alarm = 0.001;
  int most_points = 60;
  std::optional<std::filesystem::path> out = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = JoinModelsOptions;
    visit(Field{"control", &O::control, "",
                "table of surveyed points: point X Y Z [sigma_X sigma_Y sigma_Z] [role]; - for a coordinate that is "
                "not given, role control or check. Nothing: that of an adjustment file or project; of models without, "
                "the frame is that of the first one"}
              .leads_to(PathKind::kFile));
    visit(Field{"covariances", &O::covariances, "",
                "table of covariances between the coordinates of a model: model point other UU UV UW VU VV VW WU WV "
                "WW, in squares of their unit"}
              .leads_to(PathKind::kFile));
    visit(Field{"pairs", &O::pairs, "",
                "of images: table of those that make models: left right. Nothing: neighbours in strips, by the points "
                "that they have in common"}
              .leads_to(PathKind::kFile));
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of model coordinates where the table gives none, in its unit; nothing: found from "
                "the residuals, beginning with a ten-thousandth of the models' extent",
                1e-12, 1e9});
    visit(
        Field{"control_sigma_m", &O::control_sigma_m, "m", "of control where its table gives none; 0: fixed", 0, 1e6});
    visit(Field{"estimate_sigma", &O::estimate_sigma, "",
                "multiply standard deviations by sigma0, even where they are given"});
    visit(Field{"anblock", &O::anblock, "",
                "join the models by cycles of plan and height, too, and compare; they are levelled first"});
    visit(Field{"bundle", &O::bundle, "",
                "of images: adjust the bundle of the same measurements, too, and compare coordinates and standard "
                "deviations; control is needed"});
    visit(Field{"chain_only", &O::chain_only, "",
                "concatenate the models, orient the chain by its control, and stop there: no adjustment, but standard "
                "deviations of the chain"});
    visit(
        Field{"false_alarm", &O::false_alarm, "1", "chance that the test finds a good coordinate suspect", 1e-9, 0.5});
    visit(Field{"most_points", &O::most_points, "1", "of images: points that a model keeps", 6, 1000});
    visit(Field{"out", &O::out, "",
                "folder for the tables (points, models, residuals, control; of images the models that were formed, "
                "with their covariances)"}
              .leads_to(PathKind::kFolder));
  }
};

/// Joins independent models: those of a table, or those that the pairs of images of an adjustment file or of a project
/// folder give. Errors: files, columns, names; no model; those of join_models().
[[nodiscard]] Result<ModelsReport> join_models_of(const std::filesystem::path& source, const JoinModelsOptions& options,
                                                  const Run& run);

}  // namespace collinea
