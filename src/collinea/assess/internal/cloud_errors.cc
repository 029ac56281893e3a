// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/cloud_errors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "collinea/assess/internal/levelled.h"
#include "collinea/assess/internal/rough_cells.h"
#include "collinea/cloud/las.h"

namespace collinea {
namespace {

constexpr std::uint64_t kLookedAt = 1'000'000;  // points, about
constexpr std::size_t kPiece = 100'000;
constexpr int kStripRows = 256;
constexpr int kStepMargin = 6;  // [cells of the truth]

// A point and where in the truth.
struct Sample {
  double x, y;
  LocatedError point;  // its error is its height so far
};

Result<std::vector<Sample>> some_points(const std::filesystem::path& cloud, const MapGrid& grid, const Run& run) {
  COLLINEA_TRY(LasReader reader, LasReader::open(cloud));
  const std::uint64_t stride = reader.header().points / kLookedAt + 1;
  std::vector<Sample> samples;
  for (std::uint64_t first = 0;;) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    COLLINEA_TRY(const std::vector<CloudPoint> points, reader.read(kPiece));
    if (points.empty()) return samples;
    for (std::size_t i = std::size_t((stride - first % stride) % stride); i < points.size(); i += stride) {
      const CloudPoint& p = points[i];
      const double x = grid.column_of(p.position.x()), y = grid.row_of(p.position.y());
      if (p.sigma_m > 0 && x >= 0 && y >= 0 && x < grid.width && y < grid.height)
        samples.push_back({x, y, {p.position.x(), p.position.y(), float(p.position.z()), p.sigma_m, p.images}});
    }
    first += points.size();
  }
}

// Errors of the samples in some rows of the truth that lie on smooth ground.
Result<> add_errors(std::span<const Sample> samples, const HeightField& truth, int row,
                    std::vector<LocatedError>& errors) {
  const int top = std::max(0, row - kStepMargin), bottom = std::min(truth.grid.height, row + kStripRows + kStepMargin);
  COLLINEA_TRY(const FloatImage heights, truth.read(0, top, truth.grid.width, bottom - top));
  const auto rough = rough_cells(heights, truth.grid.cell_m, kStepMargin, kSteepestSmooth);
  for (const Sample& sample : samples) {
    if (rough.at(int(sample.x), int(sample.y) - top)) continue;
    const float height_m = bilinear(heights, sample.x, sample.y - top);
    if (std::isnan(height_m)) continue;
    errors.push_back(sample.point);
    errors.back().error_m -= height_m;
  }
  return {};
}

CloudErrors judged(const std::vector<LocatedError>& errors) {
  CloudErrors judged;
  judged.points = errors.size();
  std::map<int, std::pair<std::size_t, double>> by_images;
  std::size_t within = 0, gross = 0;
  for (const LocatedError& one : errors) {
    const double sigmas = std::abs(double(one.error_m)) / double(one.sigma_m);
    within += sigmas <= kBoundSigmas;
    gross += sigmas > kGrossSigmas;
    if (sigmas > kGrossSigmas) continue;
    auto& [points, squares] = by_images[one.images];
    ++points;
    squares += sigmas * sigmas;
  }
  judged.within_bounds = double(within) / double(errors.size());
  judged.share_gross = double(gross) / double(errors.size());
  for (const auto& [images, sum] : by_images)
    judged.by_images.push_back({images, sum.first, std::sqrt(sum.second / double(sum.first))});
  return judged;
}

}  // namespace

Result<CloudErrors> cloud_errors(const std::filesystem::path& cloud, const HeightField& truth, const Run& run) {
  COLLINEA_TRY(std::vector<Sample> samples, some_points(cloud, truth.grid, run));
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.y < b.y; });
  std::vector<LocatedError> errors;
  for (auto begin = samples.begin(); begin != samples.end();) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    const int row = int(begin->y) / kStripRows * kStripRows;
    const auto end = std::find_if(begin, samples.end(), [&](const Sample& one) { return one.y >= row + kStripRows; });
    COLLINEA_TRY(add_errors({begin, end}, truth, row, errors));
    begin = end;
  }
  return take_off_plane(errors) ? judged(errors) : CloudErrors();
}

}  // namespace collinea
