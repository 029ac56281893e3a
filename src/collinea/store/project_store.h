// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/block/features.h"
#include "collinea/store/editable_setup.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// How a step ended: what it was made from, what it cost and what came of it.
struct StepRecord {
  std::string inputs_hash;  ///< fingerprint of everything it read: options, earlier steps' outputs
  std::string output_hash;  ///< fingerprint of what it left behind
  double seconds = 0, cpu_seconds = 0, peak_memory_bytes = 0;
  StepOutcome outcome;

  [[nodiscard]] std::string name() const { return std::string(step_of(outcome)); }  ///< "detect", ...
};

/// The record of a kind among those of the steps; as nothing was made when the step is not done.
template <class Record>
[[nodiscard]] Record outcome_in(std::span<const StepRecord> steps) {
  for (const StepRecord& step : steps)
    if (const auto* record = std::get_if<Record>(&step.outcome)) return *record;
  return {};
}

/// Covariances of an adjusted block, by the sigmas that were used (sigma0 taken as 1). Empty: not known.
struct BlockCovariances {
  std::map<ImageId, Eigen::Matrix<double, 6, 6>> poses;  ///< [rotation (rad, in world), centre (m)], as Examined
  std::map<CameraId, Eigen::MatrixXd> cameras;           ///< of Camera::params
  std::vector<Eigen::Matrix3d> points;                   ///< [m^2], parallel to Block::points
};

using TakeTie = std::function<void(PointId id, const TiePoint& point, std::span<const Observation> observations)>;

struct ProjectStoreState;

/// block.db of a project folder: SQLite in WAL mode, every call one transaction. May be used from several threads
/// at once (calls are serialised inside). A killed program loses at most the call in work.
class ProjectStore {
 public:
  /// Opens PROJECT/block.db, created when missing. `patience`: how long a call waits for another program's writing.
  /// Errors: folder cannot be made, not a collinea database, newer schema.
  static Result<ProjectStore> open(const std::filesystem::path& project,
                                   std::chrono::milliseconds patience = std::chrono::seconds(10));

  /// Opens what is there to look at it, also where the folder cannot be written: every write is an error then. Errors:
  /// no block.db, and as above.
  static Result<ProjectStore> open_to_read(const std::filesystem::path& project);
  /// The same without a try to write, wherever it is.
  static Result<ProjectStore> open_read_only(const std::filesystem::path& project);

  [[nodiscard]] const std::filesystem::path& folder() const;  ///< PROJECT

  /// Georeference, cameras, images, control with its observations and what was measured on the ground: what is known
  /// before orientation. Replaces all of it; `edit`: and makes the control what edits say, before anybody sees it
  /// without. An orientation of images or control points that are no longer there is erased; another one stays.
  Result<> write_setup(const Block& block, const EditControl& edit = {});
  /// Makes the control what edits say, in one transaction; rows alone that differ are written. An orientation stays as
  /// it is, with the points it was made with.
  Result<> edit_setup(const EditControl& edit);
  Result<EditableSetup> read_editable_setup() const;
  /// The number of the last edit that the setup holds; 0 without any.
  Result<std::uint64_t> last_edit() const;
  /// Cameras, poses, tie points, observations, control observations of an oriented block. Replaces all of it, and what
  /// an adjustment left.
  Result<> write_orientation(const Block& block);
  /// The same of a block that an adjustment made of the one that was oriented, with covariances. What was oriented is
  /// kept, so that another adjustment begins where this one did.
  Result<> write_adjustment(const Block& block, const BlockCovariances& covariances);
  /// As write_orientation wrote it, whatever was adjusted since; otherwise as read_block.
  Result<Block> read_found() const;
  /// Of the adjusted block; empty where it was not adjusted, or nothing was known.
  Result<BlockCovariances> read_covariances() const;
  /// Everything in one block; with the control points of the setup those that the orientation was made with and that
  /// edits have removed since. Before orientation there are no poses; cameras and control observations are as set up.
  Result<Block> read_block() const;
  /// As read_block, without tie points and their observations, which take more memory than all the rest.
  Result<Block> read_orientation() const;
  /// Hands on what read_orientation left out, point by point in the order of a block, with the observations of each.
  /// `block`: what that gave. `take` must not use the store.
  Result<> read_ties(const Block& block, const TakeTie& take) const;
  /// As read_block, but as it was set up: no poses, no points, cameras and control observations before adjustment.
  Result<Block> read_setup() const;
  /// The same with control points that edits removed, which records of steps may still name.
  Result<Block> read_setup_for_names() const;

  /// A fingerprint of all that write_setup wrote.
  Result<std::uint64_t> setup_hash() const;

  Result<> write_features(ImageId image, const Features& features, const std::string& inputs_hash);
  Result<Features> read_features(ImageId image) const;
  Result<std::vector<Keypoint>> read_keypoints(ImageId image) const;
  /// The inputs_hash stored with the features of each image that has some.
  Result<std::map<ImageId, std::string>> features_done() const;
  Result<> erase_features(ImageId image);
  Result<std::size_t> count_features(ImageId image) const;
  /// Gives features to other images, as when the images were numbered anew. Those that an image had that now gets
  /// others are erased; all others stay.
  Result<> renumber_features(const std::map<ImageId, ImageId>& new_from_old);

  /// Also pairs that failed are written (geometry kNone, no matches), so that they are not tried again.
  Result<> write_pairs(const std::vector<ImagePair>& pairs, const std::string& inputs_hash);
  Result<std::vector<ImagePair>> read_pairs() const;  ///< sorted by (first, second)
  Result<std::vector<std::pair<ImageId, ImageId>>> pairs_done(const std::string& inputs_hash) const;
  Result<> erase_pairs_except(const std::string& inputs_hash);

  Result<> write_step(const StepRecord& step);
  Result<> erase_step(const std::string& name);
  /// What came of a step that is done, as it has to be said now; its inputs and its place among the steps stay.
  Result<> write_outcome(const StepOutcome& outcome);
  /// Nothing: the step is not done. Errors of this and read_steps: kUnsupported when another version of the program
  /// recorded it, kBadFormat when the record is damaged.
  Result<std::optional<StepRecord>> read_step(const std::string& name) const;
  Result<std::vector<StepRecord>> read_steps() const;  ///< in the order they were written
  /// The outcome of the step that leaves such a record. Error: kNotFound when it is not done; as above.
  template <class Record>
  Result<Record> read_outcome() const {
    COLLINEA_TRY(auto step, read_step(std::string(Record::kStep)));
    if (!step) return fail(Errc::kNotFound, "the step " + std::string(Record::kStep) + " is not done yet");
    return std::get<Record>(std::move(step->outcome));
  }

  ProjectStore(ProjectStore&&) noexcept;
  ProjectStore& operator=(ProjectStore&&) noexcept;
  ~ProjectStore();

 private:
  ProjectStore();
  std::unique_ptr<ProjectStoreState> state_;
};

}  // namespace collinea
