// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>

#include "blocks.h"
#include "collinea/report/finding_words.h"
#include "rows.h"

namespace collinea::bench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Exact image points of where everything is now; what is no longer seen goes.
void project_again(Block& block) {
  const auto move = [&](auto& seen, const Eigen::Vector3d& position) {
    const auto pixel = project(block.camera_of(seen.image), pose_of(block, seen.image) * position);
    const bool in = pixel && inside(block.camera_of(seen.image), *pixel);
    if (in) seen.pixel = *pixel;
    return !in;
  };
  std::erase_if(block.observations,
                [&](auto& seen) { return move(seen, block.points.at(seen.point).position_in_world); });
  std::erase_if(block.control_observations,
                [&](auto& seen) { return move(seen, block.control.at(seen.point).position_in_world); });
}

void forget_positions(Block& block) {
  for (auto& [id, image] : block.images) image.position.reset();
}

void keep_images(Block& block, std::uint32_t count) {
  for (const auto& [id, pose] : oriented_images(block))
    if (id.value > count) remove_pose(block, id);
  std::erase_if(block.observations, [&](const auto& seen) { return seen.image.value > count; });
  std::erase_if(block.control_observations, [&](const auto& seen) { return seen.image.value > count; });
}

void look_straight_down(Block& block) {
  for (auto [id, pose] : oriented_images(block)) {
    Eigen::Vector3d centre = centre_of(pose);
    centre.z() = 60;
    pose.rotation = Eigen::Quaterniond(0, 1, 0, 0);
    pose.translation = -(pose.rotation * centre);
    set_pose(block, id, pose);
  }
  for (auto& [id, point] : block.points) point.position_in_world.z() = 0;
  for (auto& [id, point] : block.control) point.position_in_world.z() = 0;
  project_again(block);
}

struct Case {
  const char* what;
  const char* code;
  Calibration calibration;
  Layout layout;
  int control;
  std::function<void(Block&)> weaken;
};

std::vector<Case> cases() {
  return {
      {"no datum", "no_datum", Calibration::kNone, Layout::kRing, 0, [](Block&) {}},
      {"one control point (scale, attitude)", "datum_defect", Calibration::kNone, Layout::kRing, 1, [](Block&) {}},
      {"two control points (turn about their line)", "datum_defect", Calibration::kNone, Layout::kRing, 2,
       [](Block&) {}},
      {"control without heights", "datum_defect", Calibration::kNone, Layout::kCrossStrips, 8,
       [](Block& block) {
         forget_positions(block);
         for (auto& [id, control] : block.control) control.sigma_m.z() = kInfinity;
       }},
      {"control in height only", "datum_defect", Calibration::kNone, Layout::kCrossStrips, 8,
       [](Block& block) {
         forget_positions(block);
         for (auto& [id, control] : block.control) control.sigma_m.head<2>().setConstant(kInfinity);
       }},
      {"three control points nearly on a line", "weak_rotation", Calibration::kNone, Layout::kRing, 3,
       [](Block& block) {
         double x = -4;
         for (auto& [id, control] : block.control) {
           control.position_in_world = {x, x == 0 ? 0.05 : 0, 3};
           x += 4;
         }
         project_again(block);
       }},
      {"one strip, positions alone (roll)", "weak_rotation", Calibration::kNone, Layout::kCrossStrips, 0,
       [](Block& block) { keep_images(block, 6); }},
      {"pairs without triple overlap", "scale_drifts", Calibration::kNone, Layout::kCrossStrips, 0,
       [](Block& block) {
         forget_positions(block);
         keep_images(block, 6);
         std::map<PointId, std::uint32_t> first;
         std::erase_if(block.observations, [&](const Observation& seen) {
           return seen.image.value > first.try_emplace(seen.point, seen.image.value).first->second + 1;
         });
       }},
      {"images turned only", "no_base", Calibration::kNone, Layout::kCrossStrips, 8,
       [](Block& block) {
         forget_positions(block);
         const Eigen::Vector3d position(50, 30, 60);
         for (auto [id, pose] : oriented_images(block)) {
           pose.translation = -(pose.rotation * position);
           set_pose(block, id, pose);
         }
         project_again(block);
       }},
      {"an image that hangs on two points", "images_left_out", Calibration::kNone, Layout::kCrossStrips, 0,
       [](Block& block) {
         int kept = 0;
         std::erase_if(block.observations,
                       [&](const Observation& seen) { return seen.image == ImageId{3} && kept++ >= 2; });
       }},
      {"focal length and height over level ground", "focal_and_height", Calibration::kFocal, Layout::kCrossStrips, 8,
       [](Block& block) {
         forget_positions(block);
         keep_images(block, 18);
         look_straight_down(block);
       }},
  };
}

}  // namespace

Rows weak_blocks(const Run& run) {
  Rows rows;
  for (const Case& one : cases()) {
    Block exact = exact_block(one.layout, {.points = 300, .control = one.control}, 4);
    one.weaken(exact);
    Measured made = measured(exact, 4);
    if (std::string_view(one.code) == "no_base") made.block.poses = exact.poses;
    ExamineOptions options{
        .adjust = {.calibration = one.calibration, .loss = Loss::kNone, .position_loss = Loss::kNone}};
    const auto adjusted = examine(made.block, made.scope, options, run);
    Row row{std::string("weak: ") + one.what, "named, with a cure", adjusted ? "not named" : adjusted.error().message};
    if (adjusted)
      for (const Finding& weak : adjusted->weaknesses)
        if (word_of(weak.code) == one.code && !weak.remedies.empty()) {
          row.measured = what_of(weak, made.block);
          row.ok = true;
          break;
        }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace collinea::bench
