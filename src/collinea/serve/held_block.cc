// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/held_block.h"

#include "collinea/marking/marking_block.h"
#include "collinea/math/median.h"
#include "collinea/project/adjustment_task.h"

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

}  // namespace

Result<HeldBlock::Marked> HeldBlock::read_marked(const std::filesystem::path& folder) {
  COLLINEA_TRY(const Project project, open_project(folder, {}));
  const AdjustmentOptions& asked = project.settings.adjust;
  COLLINEA_TRY(ProjectAdjustment adjustment, adjustment_of(project, asked));
  AdjustmentTask& task = adjustment.task;
  if (task.block.images.size() > kMostImages)
    return fail(Errc::kUnsupported, "the block is too large to be adjusted after each mark: run adjust");
  SigmaFactors factors = as_given();
  if (task.scope.use_control && !asked.given_sigmas) factors = factors_of(adjustment.orientation.sigma_factors);
  COLLINEA_TRY(MarkedBlock block,
               MarkedBlock::of(std::move(task.block), task.scope, task.options.adjust, BlockControl::kLeftOut, {}));
  return Marked{std::move(block), factors};
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
  return held->block.adjust(points_of(control, marks, held->factors));
}

Result<std::optional<NextMark>> HeldBlock::next_mark(const std::map<ControlId, ControlPoint>& control,
                                                     const std::vector<ControlObservation>& marks,
                                                     std::span<const PossibleMark> possible) {
  const std::lock_guard lock(marked_mutex_);
  COLLINEA_TRY(Marked* const held, marked());
  return best_next_mark(held->block, points_of(control, marks, held->factors), possible);
}

Result<HeightSpan> HeldBlock::span_of(const std::filesystem::path& surface) {
  const std::lock_guard lock(span_mutex_);
  std::error_code error;
  KnownSpan now{std::filesystem::file_size(surface, error), {}, {}};
  now.changed = std::filesystem::last_write_time(surface, error);
  if (span_ && !error && span_->bytes == now.bytes && span_->changed == now.changed) return span_->span;
  COLLINEA_TRY(const HeightField heights, open_height_field(surface));
  COLLINEA_TRY(now.span, height_span(heights, {}));
  span_ = now;
  return now.span;
}

}  // namespace collinea
