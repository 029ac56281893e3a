// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/project_views.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/block/world_frame.h"
#include "collinea/edit/read_work.h"
#include "collinea/jobs/marking_project.h"
#include "collinea/project/project.h"
#include "collinea/report/adjustment_report.h"
#include "collinea/steps/step_list.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// Size and time of change of the files that hold a project. An empty log of the database is as good as none: reading
// makes one.
std::string state_of(const fs::path& folder) {
  Hash hash;
  for (const char* name : {"project.json", "block.db", "block.db-wal", "journal.jsonl"}) {
    std::error_code error;
    const auto bytes = fs::file_size(folder / name, error);
    const auto changed = error || bytes == 0 ? fs::file_time_type() : fs::last_write_time(folder / name, error);
    hash.add(error ? 0 : std::uint64_t(bytes)).add(std::uint64_t(error ? 0 : changed.time_since_epoch().count()));
  }
  return hash.hex();
}

template <class Record>
Result<std::optional<Record>> record_of(const ProjectStore& store) {
  auto record = store.read_outcome<Record>();
  if (record) return std::optional(*std::move(record));
  if (record.error().code == Errc::kNotFound) return std::optional<Record>();
  return tl::unexpected(std::move(record).error());
}

// Of the steps that write the block; empty where none did.
Result<std::string> block_state_of(const ProjectStore& store) {
  Hash hash;
  bool is_written = false;
  for (const Step step : {Step::kOrient, Step::kAdjust}) {
    auto record = store.read_step(std::string(word_of(step)));
    if (!record && record.error().code != Errc::kUnsupported) return tl::unexpected(std::move(record).error());
    if (!record || !*record) continue;
    is_written = true;
    hash.add((*record)->inputs_hash).add((*record)->output_hash);
  }
  return is_written ? hash.hex() : std::string();
}

double value_in(const nlohmann::json& one, const char* name) {
  const auto found = one.find(name);
  return found != one.end() && found->is_number() ? found->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Result<std::shared_ptr<const ProjectView>> ProjectView::read(const ServedProject& project, std::string state,
                                                             const ProjectView* before) {
  auto view = std::make_shared<ProjectView>();
  view->project = project;
  view->state = std::move(state);
  view->held_ = std::make_shared<HeldBlock>(project.folder);
  const auto opened = open_project(project.folder, {});
  if (!opened && opened.error().code == Errc::kNotFound) return view;  // it was only made
  if (!opened) return tl::unexpected(opened.error());
  COLLINEA_TRY(view->block, opened->store.read_orientation());
  COLLINEA_TRY(Block setup, opened->store.read_setup());
  view->control = std::move(setup.control);
  view->marks = std::move(setup.control_observations);
  COLLINEA_TRY(view->work, read_work(*opened));
  for (const auto& [id, image] : view->block.images) view->image_files.emplace(id, opened->image_file(image));
  COLLINEA_TRY(view->frame, world_frame(view->block));
  COLLINEA_TRY(view->orientation, record_of<OrientationRecord>(opened->store));
  COLLINEA_TRY(view->adjustment, record_of<AdjustmentRecord>(opened->store));
  COLLINEA_TRY(view->held_state_, block_state_of(opened->store));
  if (before && !view->held_state_.empty() && before->held_state_ == view->held_state_) view->held_ = before->held_;
  if (view->frame)
    view->map_from_world_ = map_from_local_rotation(*view->frame, Eigen::Vector3d::Zero()).toRotationMatrix();
  if (view->adjustment) view->read_tests();
  return view;
}

// The file of the adjustment holds the tests of all that was given, by names that a block gives them. It may be missing
// or of another adjustment: what it does not name is not known.
void ProjectView::read_tests() {
  const auto text = read_file(project.folder / "adjustment" / "adjustment.json");
  if (!text) return;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const auto list = nlohmann::json::json_pointer("/reliability/control_and_positions");
  if (json.is_discarded() || !json.contains(list) || !json.at(list).is_array()) return;
  std::map<std::string, const nlohmann::json*> by_name;
  for (const nlohmann::json& one : json.at(list))
    if (one.is_object() && one.contains("observation") && one.at("observation").is_string())
      by_name.emplace(one.at("observation").get<std::string>(), &one);
  for (std::size_t i = 0; i < block.control_observations.size(); ++i) {
    const ControlObservation& mark = block.control_observations[i];
    if (!block.control.contains(mark.point) || !block.images.contains(mark.image)) continue;
    MarkTests tests;
    for (int axis = 0; axis < 2; ++axis) {
      const auto found = by_name.find(name_of(
          TestedObservation{.group = ObservationGroup::kControlImages, .source = std::uint32_t(i), .axis = axis},
          block));
      const nlohmann::json one = found == by_name.end() ? nlohmann::json::object() : *found->second;
      tests.residual_px[axis] = value_in(one, "residual");
      tests.w[axis] = value_in(one, "w");
      tests.redundancy[axis] = value_in(one, "redundancy");
      tests.detectable_px[axis] = value_in(one, "minimal_detectable_bias");
    }
    if (tests.residual_px.allFinite()) tests_.emplace(std::pair(mark.point, mark.image), tests);
  }
}

MarkingBlock ProjectView::marking(const TiedBlock& ties) const {
  return {ties.block, ties.observations, ties.covariances.poses, sigma_scale(adjustment)};
}

MarkingBlock ProjectView::plotting(const TiedBlock& ties) const {
  MarkingBlock all = marking(ties);
  if (held_->has_poses_together())
    all.poses_together = [held = held_](std::span<const ImageId> images) { return held->poses_together(images); };
  return all;
}

std::optional<MarkTests> ProjectView::tests_of(const ControlObservation& mark) const {
  const auto found = tests_.find({mark.point, mark.image});
  if (found == tests_.end()) return std::nullopt;
  for (const ControlObservation& adjusted : block.control_observations)
    if (adjusted.point == mark.point && adjusted.image == mark.image)
      return (adjusted.pixel - mark.pixel).norm() < 1e-6 ? std::optional(found->second) : std::nullopt;
  return std::nullopt;
}

Eigen::Vector3d ProjectView::in_map(const Eigen::Vector3d& position_in_world) const {
  return frame ? frame->map_from_local(position_in_world) : position_in_world;
}

Result<std::shared_ptr<const ProjectView>> ProjectViews::of(const ServedProject& project) {
  const std::lock_guard lock(mutex_);
  std::string state = state_of(project.folder);
  std::shared_ptr<const ProjectView> before;
  for (auto known = views_.begin(); known != views_.end(); ++known) {
    if ((*known)->project.id != project.id) continue;
    if ((*known)->state == state) {
      views_.splice(views_.begin(), views_, known);
      return views_.front();
    }
    before = *known;
    views_.erase(known);
    break;
  }
  COLLINEA_TRY(auto view, ProjectView::read(project, std::move(state), before.get()));
  views_.push_front(view);
  if (views_.size() > kMost) views_.pop_back();
  return view;
}

}  // namespace collinea
