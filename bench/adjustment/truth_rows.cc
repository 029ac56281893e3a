// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "blocks.h"
#include "collinea/geometry/rotation.h"
#include "collinea/report/finding_words.h"
#include "rows.h"

namespace collinea::bench {
namespace {

// 95 % of chi-squared with 1, 3, 6 and 8 degrees of freedom.
constexpr double kChi1 = 3.8415, kChi3 = 7.8147, kChi6 = 12.5916, kChi8 = 15.5073;
constexpr double kDeviations = 4;

// Squared lengths of errors in units of their covariances. Those of one block are correlated: its mean is one sample.
class Lengths {
 public:
  Lengths(int freedom, double limit) : freedom_(freedom), limit_(limit) {}
  void add(double squared) {
    block_ += squared / freedom_;
    ++in_block_;
    inside_ += squared < limit_;
    ++all_;
  }
  void end_block() {
    if (in_block_ == 0) return;
    const double mean = block_ / in_block_;
    sum_ += mean;
    squares_ += mean * mean;
    ++blocks_;
    block_ = in_block_ = 0;
  }
  [[nodiscard]] double mean() const { return sum_ / blocks_; }
  [[nodiscard]] double deviation() const {
    return std::sqrt(std::max(0.0, squares_ / blocks_ - mean() * mean()) / blocks_);
  }
  [[nodiscard]] bool in_bound() const { return std::abs(mean() - 1) < kDeviations * deviation(); }
  [[nodiscard]] double share() const { return inside_ / all_; }
  [[nodiscard]] double all() const { return all_; }

 private:
  int freedom_;
  double limit_, block_ = 0, in_block_ = 0, sum_ = 0, squares_ = 0, blocks_ = 0, inside_ = 0, all_ = 0;
};

void take_left_out(const std::vector<LeftOutPoint>& points, Lengths& lengths) {
  for (const LeftOutPoint& one : points)
    for (int axis = 0; axis < 3; ++axis)
      lengths.add(std::pow(one.difference_m[axis] / one.difference_sigma_m[axis], 2));
}

struct Errors {
  Lengths poses{6, kChi6}, points{3, kChi3}, cameras{8, kChi8}, left_out{1, kChi1}, folded{1, kChi1};

  void take(const Examined& adjusted, const Block& exact) {
    const double variance = std::pow(sigma_scale(adjusted), 2);
    for (const auto& [id, pose] : adjusted.cam_from_world) {
      const Rigid3& its = pose_of(exact, id);
      Eigen::Matrix<double, 6, 1> error;
      error << rotation_vector(pose.rotation.conjugate() * its.rotation), centre_of(its) - centre_of(pose);
      poses.add(error.dot(adjusted.pose_covariance.at(id).llt().solve(error)) / variance);
    }
    for (std::size_t i = 0; i < adjusted.points.size(); ++i) {
      const Eigen::Vector3d error =
          exact.points.at(adjusted.points[i].first).position_in_world - adjusted.points[i].second;
      points.add(error.dot(adjusted.point_covariance[i].llt().solve(error)) / variance);
    }
    for (const auto& [id, camera] : adjusted.cameras) {
      constexpr int kFree = 8;  // the parameters of "brown" come first
      Eigen::Matrix<double, kFree, 1> error;
      for (int k = 0; k < kFree; ++k) error[k] = exact.cameras.at(id).params[k] - camera.params[k];
      const Eigen::Matrix<double, kFree, kFree> c = adjusted.camera_covariance.at(id).topLeftCorner<kFree, kFree>();
      cameras.add(error.dot(c.llt().solve(error)) / variance);
    }
    take_left_out(adjusted.reliability->left_out, left_out);
    take_left_out(adjusted.reliability->folded.points, folded);
    for (Lengths* one : {&poses, &points, &cameras, &left_out, &folded}) one->end_block();
  }
};

// With all blocks the bound on shares is the one that is asked for, without allowance for chance: 600 cameras scatter
// by 0.9 %. With fewer there is one.
Row row(const std::string& what, const Lengths& lengths, bool all_blocks) {
  const double of_chance = all_blocks ? 0 : kDeviations * std::sqrt(0.95 * 0.05 / lengths.all());
  const bool share = std::abs(lengths.share() - 0.95) < std::max(0.02, of_chance);
  return {what,
          std::string("mean chi-squared / freedom 1 within 4 deviations; 93-97 % of errors in the 95 % region") +
              (all_blocks ? "" : ", or within 4 binomial deviations of 95 %"),
          fmt::format("{:.3f} +- {:.3f}; {:.1f} % of {:.0f}", lengths.mean(), lengths.deviation(),
                      100 * lengths.share(), lengths.all()),
          lengths.in_bound() && share};
}

}  // namespace

Rows true_errors(const Effort& effort, const Run& run) {
  std::array<Errors, 3> of_layout;
  Errors all;
  int failed = 0, alarms = 0;
  std::string named;  // the last alarm
  for (int i = 0; i < effort.blocks; ++i) {
    const auto layout = static_cast<Layout>(i % 3);
    const auto seed = static_cast<std::uint64_t>(1000 + i);
    const Block exact = exact_block(layout, {}, seed);
    const Measured made = measured(exact, seed);
    ExamineOptions options = exact_options(Calibration::kBrown);
    options.point_covariances = options.reliability = true;
    const auto adjusted = examine(made.block, made.scope, options, run);
    if (!adjusted || !adjusted->reliability || !adjusted->converged) {
      ++failed;
      continue;
    }
    alarms += !adjusted->weaknesses.empty();
    if (!adjusted->weaknesses.empty()) named = what_of(adjusted->weaknesses.front(), made.block);
    of_layout[static_cast<std::size_t>(i % 3)].take(*adjusted, exact);
    all.take(*adjusted, exact);
  }
  Rows rows;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = kLayoutNames[k];
    rows.push_back(row(name + ": poses", of_layout[k].poses, effort.all_blocks()));
    rows.push_back(row(name + ": points", of_layout[k].points, effort.all_blocks()));
    rows.push_back(row(name + ": cameras", of_layout[k].cameras, effort.all_blocks()));
  }
  rows.push_back(
      row("leave-one-out of control: predicted against real differences", all.left_out, effort.all_blocks()));
  rows.push_back(row("control left out in five parts", all.folded, effort.all_blocks()));
  rows.push_back(
      {fmt::format("{} blocks adjusted", effort.blocks), "none fails", fmt::format("{} failed", failed), failed == 0});
  rows.push_back(
      {"sound blocks called weak", "none", std::to_string(alarms) + (alarms > 0 ? ": " + named : ""), alarms == 0});
  return rows;
}

}  // namespace collinea::bench
