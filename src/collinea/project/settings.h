// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "collinea/dense/depth_map.h"
#include "collinea/epipolar/two_view.h"
#include "collinea/feature/detect.h"
#include "collinea/import/import.h"
#include "collinea/match/descriptors.h"
#include "collinea/match/pairs.h"
#include "collinea/orient/adjustment_options.h"
#include "collinea/orient/options.h"
#include "collinea/ortho/orthophoto.h"
#include "collinea/report/report_options.h"
#include "collinea/surface/dsm.h"
#include "collinea/surface/dtm.h"
#include "collinea/surface/frames_options.h"

namespace collinea {

/// All that was asked of a project: project.json.
struct Settings {
  std::string photos;  ///< absolute path of the photo folder
  std::uint64_t seed = 1;
  ImportOptions import;
  DetectOptions detect;
  PairOptions pairs;
  MatchOptions match;
  VerifyOptions verify;
  OrientOptions orient;
  AdjustmentOptions adjust;
  DenseOptions densify;
  DsmOptions surface;
  DtmOptions terrain;
  OrthoOptions ortho;
  FramesOptions frames;
  ReportOptions report;

  /// Calls visit(name of the step, name of the group, options) for every group of options: the only list of them.
  template <class Self, class Visit>
  static void each(Self& self, Visit&& visit) {
    visit("import", "import", self.import);
    visit("detect", "detect", self.detect);
    visit("match", "pairs", self.pairs);
    visit("match", "match", self.match);
    visit("match", "verify", self.verify);
    for_each_group("orient", self.orient, [&](const char* group, auto& options) { visit("orient", group, options); });
    for_each_group("adjust", self.adjust, [&](const char* group, auto& options) { visit("adjust", group, options); });
    visit("densify", "densify", self.densify);
    visit("surface", "surface", self.surface);
    visit("terrain", "terrain", self.terrain);
    visit("ortho", "ortho", self.ortho);
    visit("frames", "frames", self.frames);
    visit("report", "report", self.report);
  }
};

/// Reads PROJECT/project.json. Errors: missing, not JSON, unknown option, value of a wrong kind or out of range.
[[nodiscard]] Result<Settings> read_settings(const std::filesystem::path& project);
[[nodiscard]] Result<> write_settings(const std::filesystem::path& project, const Settings& settings);
/// Checks every option against its description, that words are among those there are to choose from, and that
/// names are UTF-8.
[[nodiscard]] Result<> validate_settings(const Settings& settings);
/// The options of one step and the seed as text, for fingerprints.
[[nodiscard]] std::string options_text(const Settings& settings, const std::string& step);
/// The options that are not as they are by default, for people: "orient.max_error_px", "2.5 px".
[[nodiscard]] std::vector<std::pair<std::string, std::string>> chosen_options(const Settings& settings);

}  // namespace collinea
