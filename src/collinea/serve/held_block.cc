// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/held_block.h"

#include "collinea/marking/marking_block.h"
#include "collinea/math/median.h"
#include "collinea/project/adjustment_task.h"
#include "collinea/project/block_precision.h"

namespace collinea {
namespace {

std::vector<BlockPoint> points_of(const std::map<ControlId, ControlPoint>& control,
                                  const std::vector<ControlObservation>& marks, const SigmaFactors& factors) {
  Block given;
  given.control = control;
  given.control_observations = marks;
  const Block block = with_sigmas(given, factors);
  std::map<ControlId, std::vector<BlockMark>> of_point;
  for (const ControlObservation& mark : block.control_observations)
    of_point[mark.point].push_back({mark.image, mark.pixel, mark.sigma_px, mark.shape});
  std::vector<BlockPoint> points;
  for (const auto& [id, point] : block.control)
    points.push_back({std::move(of_point[id]),
                      SurveyedPosition{point.position_in_world, point.sigma_m, point.correlation, point.role}});
  return points;
}

// Measurements between points by their numbers; what is of points that were removed is left out.
std::vector<PointLink> links_of(const std::map<ControlId, ControlPoint>& control,
                                const std::vector<GeodeticObservation>& ground) {
  std::vector<PointLink> links;
  for (const GeodeticObservation& one : ground) {
    const auto from = control.find(one.from), to = control.find(one.to);
    if (from == control.end() || to == control.end()) continue;
    links.push_back(
        {std::size_t(std::distance(control.begin(), from)), std::size_t(std::distance(control.begin(), to)), one});
  }
  return links;
}

}  // namespace

Result<HeldBlock::Marked> HeldBlock::read_marked(const std::filesystem::path& folder) {
  COLLINEA_TRY(const Project project, open_project(folder, {}));
  const AdjustmentOptions& asked = project.settings.adjust;
  COLLINEA_TRY(ProjectAdjustment adjustment, adjustment_with_marks(project));
  AdjustmentTask& task = adjustment.task;
  if (task.block.images.size() > kMostImages)
    return fail(Errc::kUnsupported, "the block is too large to be adjusted after each mark: run adjust");
  SigmaFactors factors = as_given();
  if (task.scope.use_control && !asked.given_sigmas) factors = factors_of(adjustment.orientation.sigma_factors);
  std::vector<GeodeticObservation> ground = task.scope.use_geodetic ? task.block.geodetic : decltype(ground)();
  COLLINEA_TRY(MarkedBlock block,
               MarkedBlock::of(std::move(task.block), task.scope, task.options.adjust, BlockControl::kLeftOut, {}));
  return Marked{std::move(block), factors, std::move(ground)};
}

Result<std::shared_ptr<const TiedBlock>> HeldBlock::ties() {
  const std::lock_guard lock(ties_mutex_);
  if (ties_) return ties_;
  auto tied = std::make_shared<TiedBlock>();
  const auto store = ProjectStore::open_to_read(project_);
  if (!store && store.error().code != Errc::kNotFound) return tl::unexpected(store.error());
  if (store) {
    COLLINEA_TRY(tied->block, store->read_block());
    COLLINEA_TRY(tied->covariances, store->read_covariances());
    if (tied->covariances.points.size() != tied->block.points.size()) tied->covariances.points.clear();
  }
  std::map<ImageId, std::vector<double>> heights;
  tied->observations = observations_by_image(tied->block);
  for (const Observation& seen : tied->block.observations)
    if (const auto point = tied->block.points.find(seen.point); point != tied->block.points.end())
      heights[seen.image].push_back(point->second.position_in_world.z());
  for (auto& [image, all] : heights) tied->ground_height[image] = median(all);
  ties_ = std::move(tied);
  return ties_;
}

Result<HeldBlock::Marked*> HeldBlock::marked() {
  if (!marked_) marked_.emplace(read_marked(project_));
  if (!*marked_) return tl::unexpected(marked_->error());
  return &**marked_;
}

Result<AdjustedMarks> HeldBlock::adjusted_with(const std::map<ControlId, ControlPoint>& control,
                                               const std::vector<ControlObservation>& marks) {
  const std::lock_guard lock(marked_mutex_);
  COLLINEA_TRY(Marked* const held, marked());
  return held->block.adjust(points_of(control, marks, held->factors), {}, links_of(control, held->ground));
}

Result<std::optional<NextMark>> HeldBlock::next_mark(const std::map<ControlId, ControlPoint>& control,
                                                     const std::vector<ControlObservation>& marks,
                                                     std::span<const PossibleMark> possible) {
  const std::lock_guard lock(marked_mutex_);
  COLLINEA_TRY(Marked* const held, marked());
  return best_next_mark(held->block, points_of(control, marks, held->factors), possible,
                        links_of(control, held->ground));
}

BlockPrecision* HeldBlock::precision() {
  if (!precision_) {
    const auto tied = ties();
    precision_ = tied ? precision_of(project_, (*tied)->block, (*tied)->covariances) : tl::unexpected(tied.error());
  }
  return *precision_ ? &**precision_ : nullptr;
}

std::optional<JointPoses> HeldBlock::poses_together(std::span<const ImageId> images) {
  const std::lock_guard lock(precision_mutex_);
  BlockPrecision* const known = precision();
  return known ? known->joint_poses(images) : std::nullopt;
}

bool HeldBlock::has_poses_together() {
  const std::lock_guard lock(precision_mutex_);
  return precision() != nullptr;
}

std::optional<HeldBlock::FileState> HeldBlock::state_of(const std::filesystem::path& file) {
  std::error_code error;
  FileState state{std::filesystem::file_size(file, error)};
  if (!error) state.changed = std::filesystem::last_write_time(file, error);
  return error ? std::nullopt : std::optional(state);
}

Result<HeightSpan> HeldBlock::span_of(const std::filesystem::path& surface) {
  const std::lock_guard lock(span_mutex_);
  const auto now = state_of(surface);
  if (span_ && now && span_->state == *now) return span_->span;
  COLLINEA_TRY(const HeightField heights, open_height_field(surface));
  COLLINEA_TRY(const HeightSpan span, height_span(heights, {}));
  if (now) span_ = KnownSpan{*now, span};
  return span;
}

Result<DrawingNow> HeldBlock::drawing_now(const Drawing& drawn, const ImagesByFile& images,
                                          const std::filesystem::path& surface,
                                          const DrawingComputer::MakePlotter& plotter) {
  const std::lock_guard lock(drawing_mutex_);
  if (auto state = state_of(surface); state != drawing_.surface) drawing_ = {state, {}};
  return drawing_.computer.drawing_now(drawn, plotter, images);
}

}  // namespace collinea
