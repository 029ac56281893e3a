// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>

#include "blocks.h"
#include "rows.h"

namespace collinea::bench {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * t.tv_usec; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_gib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / (1 << 20);
}

}  // namespace

Rows large_block(const Effort& effort, const Run& run) {
  const int rows = static_cast<int>(std::sqrt(effort.large_images / 1.6)), columns = effort.large_images / rows;
  const Measured made = measured(large_exact_block(rows, columns, effort.large_points), 1);
  const std::string size = fmt::format("{} images, {} points, {} rays", made.block.images.size(),
                                       made.block.points.size(), made.block.observations.size());
  Rows table;
  ExamineOptions options{.adjust = {.calibration = Calibration::kBrown}};
  auto begin = std::chrono::steady_clock::now();
  double used = processor_seconds();
  auto estimate = adjust(made.block, made.scope, options.adjust, run);
  double wall = seconds_since(begin);
  used = processor_seconds() - used;
  if (!estimate) return {{size, "", estimate.error().message, false}};
  table.push_back({size + ": adjusted to convergence", "60 s on two cores",
                   fmt::format("{:.1f} s, {:.1f} processor s, {} iterations, sigma0 {:.4f}", wall, used,
                               estimate->iterations, estimate->sigma0),
                   wall < 60 && estimate->converged && std::abs(estimate->sigma0 - 1) < 0.01});
  Block there = made.block;
  apply(*estimate, there);
  options.point_covariances = true;
  begin = std::chrono::steady_clock::now();
  used = processor_seconds();
  const auto adjusted = examine(there, made.scope, options, run);
  wall = seconds_since(begin);
  used = processor_seconds() - used;
  const bool all = adjusted && adjusted->point_covariance.size() == adjusted->points.size() &&
                   adjusted->pose_covariance.size() == adjusted->cam_from_world.size();
  table.push_back({size + ": all covariances", "60 s and 4 GiB on two cores",
                   fmt::format("{:.1f} s, {:.1f} processor s, {:.2f} GiB", wall, used, peak_gib()),
                   all && wall < 60 && peak_gib() < 4});
  return table;
}

}  // namespace collinea::bench
