// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/marking/next_mark.h"
#include "collinea/quality/joint_poses.h"
#include "collinea/quality/marked_points.h"
#include "collinea/quality/variance_components.h"
#include "collinea/restitution/drawing_now.h"
#include "collinea/store/project_store.h"
#include "collinea/surface/monoplot.h"

namespace collinea {

/// A block with all its tie points.
struct TiedBlock {
  Block block;
  BlockCovariances covariances;                              ///< empty: not known
  std::map<ImageId, std::vector<std::size_t>> observations;  ///< of each image, indices in Block::observations
  /// Median height of the tie points that each image sees, in the world.
  std::map<ImageId, double> ground_height;
};

/// What follows from the oriented block of a project alone, whatever is edited: made when it is first asked for, and
/// kept. May be used from several threads.
class HeldBlock {
 public:
  /// Larger blocks are not adjusted with marks while somebody waits.
  static constexpr std::size_t kMostImages = 3000;

  explicit HeldBlock(std::filesystem::path project) : project_(std::move(project)) {}

  /// Errors: those of ProjectStore::read_block().
  [[nodiscard]] Result<std::shared_ptr<const TiedBlock>> ties();
  /// Control points with the marks that they have now, adjusted with the whole block (MarkedBlock), their standard
  /// deviations as the adjustment takes them, and what was measured on the ground between them; parallel to `control`.
  /// Seconds the first time, then milliseconds. Errors: not oriented, more than kMostImages; those of MarkedBlock.
  [[nodiscard]] Result<AdjustedMarks> adjusted_with(const std::map<ControlId, ControlPoint>& control,
                                                    const std::vector<ControlObservation>& marks);
  /// Of places in images where points (by their order in `control`) could be marked the one that helps all most
  /// (best_next_mark). Errors: as above.
  [[nodiscard]] Result<std::optional<NextMark>> next_mark(const std::map<ControlId, ControlPoint>& control,
                                                          const std::vector<ControlObservation>& marks,
                                                          std::span<const PossibleMark> possible);
  /// What the adjustment knows of images together (precision_of()): seconds the first time. Nothing: not known.
  [[nodiscard]] std::optional<JointPoses> poses_together(std::span<const ImageId> images);
  /// Whether it is known of any. As long as above.
  [[nodiscard]] bool has_poses_together();
  /// A drawing as the adjustment has it; features that are as they were are not computed again. `plotter` makes what
  /// others are plotted in, on the surface in that file (there may be none). Errors: those of `plotter`.
  [[nodiscard]] Result<DrawingNow> drawing_now(const Drawing& drawn, const ImagesByFile& images,
                                               const std::filesystem::path& surface,
                                               const DrawingComputer::MakePlotter& plotter);
  /// Between which heights a surface lies, read again when its file changes. Errors: height_span().
  [[nodiscard]] Result<HeightSpan> span_of(const std::filesystem::path& surface);

 private:
  std::filesystem::path project_;
  std::mutex ties_mutex_, marked_mutex_, span_mutex_, precision_mutex_, drawing_mutex_;
  struct FileState {
    std::uintmax_t bytes = 0;
    std::filesystem::file_time_type changed = {};
    bool operator==(const FileState&) const = default;
  };
  static std::optional<FileState> state_of(const std::filesystem::path& file);  // nothing: it is not there
  struct KnownSpan {
    FileState state;
    HeightSpan span;
  };
  std::optional<KnownSpan> span_;
  struct KnownDrawing {
    std::optional<FileState> surface;
    DrawingComputer computer;
  };
  KnownDrawing drawing_;
  std::shared_ptr<const TiedBlock> ties_;
  BlockPrecision* precision();                       // the mutex is held; null: not known
  std::optional<Result<BlockPrecision>> precision_;  // an error is not tried again
  struct Marked {
    MarkedBlock block;
    SigmaFactors factors;
    std::vector<GeodeticObservation> ground;  // as the adjustment takes it
  };
  static Result<Marked> read_marked(const std::filesystem::path& project);
  Result<Marked*> marked();               // the mutex is held
  std::optional<Result<Marked>> marked_;  // an error is not tried again
};

}  // namespace collinea
