// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/edit/edited_work.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/marking/marking_block.h"
#include "collinea/raster/tile_cache.h"
#include "collinea/serve/held_block.h"
#include "collinea/serve/project_files.h"
#include "collinea/store/project_store.h"

namespace collinea {

/// The tests of a mark by the adjustment of the whole block, of column and row.
struct MarkTests {
  Eigen::Vector2d residual_px, w, redundancy, detectable_px;  ///< NaN, or infinite: not known
};

/// What is known of a project in one state of its files. Nothing of it changes, so that several threads may look; what
/// is dear to have (HeldBlock) is made when it is first asked for, and goes on from state to state until the block is
/// oriented or adjusted anew.
class ProjectView {
 public:
  ServedProject project;
  std::string state;                          ///< other in every state of the project
  Block block;                                ///< as read_orientation(): no tie points; empty before import
  std::map<ControlId, ControlPoint> control;  ///< as set up: with what was edited since the block was oriented
  std::vector<ControlObservation> marks;      ///< the same of control
  EditedWork work;                            ///< what edits say of anything else
  std::map<ImageId, std::filesystem::path> image_files;  ///< photographs that steps work on
  std::optional<LocalFrame> frame;                       ///< nothing: no location on Earth
  std::optional<OrientationRecord> orientation;
  std::optional<AdjustmentRecord> adjustment;

  /// Errors: those of ProjectStore::read_block().
  [[nodiscard]] Result<std::shared_ptr<const TiedBlock>> ties() const { return held_->ties(); }
  /// What points are marked in; refers to the block with its ties.
  [[nodiscard]] MarkingBlock marking(const TiedBlock& ties) const;
  /// What vertices are plotted in: the same, with what the adjustment knows of images together.
  [[nodiscard]] MarkingBlock plotting(const TiedBlock& ties) const;
  [[nodiscard]] const LocalFrame* frame_or_null() const { return frame ? &*frame : nullptr; }
  /// All control points with their marks, as they are now, adjusted with the whole block; parallel to `control`.
  /// Errors: those of HeldBlock.
  [[nodiscard]] Result<AdjustedMarks> adjusted_with_marks() const { return held_->adjusted_with(control, marks); }

  /// Of places where its control points could be marked the one that helps all of them most. Errors: as above.
  [[nodiscard]] Result<std::optional<NextMark>> next_mark(std::span<const PossibleMark> possible) const {
    return held_->next_mark(control, marks, possible);
  }

  /// Between which heights a surface of the project lies. Errors: those of HeldBlock.
  [[nodiscard]] Result<HeightSpan> span_of_surface(const std::filesystem::path& surface) const {
    return held_->span_of(surface);
  }

  /// The drawing as the adjustment has it. Errors: those of `plotter`.
  [[nodiscard]] Result<DrawingNow> drawing_now(const DrawingComputer::MakePlotter& plotter) const {
    return held_->drawing_now(work.drawing, images_by_file(block), project.folder / "products" / "dsm.tif", plotter);
  }

  /// The tests that the adjustment left of a mark; nothing when it took no part, or has been moved since.
  [[nodiscard]] std::optional<MarkTests> tests_of(const ControlObservation& mark) const;

  /// Of positions and covariances; those of the world where there is no map.
  [[nodiscard]] Eigen::Vector3d in_map(const Eigen::Vector3d& position_in_world) const;
  /// From the axes of the world to those of the map, in the middle of the block.
  [[nodiscard]] Eigen::Matrix3d map_from_world() const { return map_from_world_; }

  /// What adjustment and settings say of the project as it is now. `before`: what was known of it, or null. Errors:
  /// settings or database cannot be read.
  static Result<std::shared_ptr<const ProjectView>> read(const ServedProject& project, std::string state,
                                                         const ProjectView* before);

 private:
  void read_tests();

  Eigen::Matrix3d map_from_world_ = Eigen::Matrix3d::Identity();
  std::map<std::pair<ControlId, ImageId>, MarkTests> tests_;
  std::string held_state_;  // of the block: steps that wrote it; empty: not by a step
  std::shared_ptr<HeldBlock> held_;
};

/// What a server remembers of its projects, so that not every request reads a database: the last few of them, each as
/// long as its files stay as they are; and tiles of their images. May be used from several threads.
class ProjectViews {
 public:
  static constexpr std::size_t kMost = 4;  ///< projects remembered

  /// Errors: settings or database cannot be read.
  [[nodiscard]] Result<std::shared_ptr<const ProjectView>> of(const ServedProject& project);

  [[nodiscard]] TileCache& tiles() { return tiles_; }

 private:
  std::mutex mutex_;
  std::list<std::shared_ptr<const ProjectView>> views_;  // the one used last first
  TileCache tiles_;
};

}  // namespace collinea
