// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kept_factor.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace collinea::bundle {
namespace {

// An element of a tile is read once for a product with a vector, but used kTile times once it is in the cache for a
// product with a tile: that is worth this much (measured with 1000 and 4000 images).
constexpr double kProductGain = 10;
constexpr double kShareOfFactor = 0.5;  // of the cost of a factor, spent at most on going without
constexpr double kFewestIterations = 3;
constexpr double kAccuracy = 0.05;  // of a step's length in standard deviations; the next step begins anew

constexpr std::uint32_t kCamera = 0, kRetained = 1,
                        kAuxiliary = 2;  // kinds of unknowns; auxiliaries have kinds of their own

// How many iterations are worth a try.
int worthwhile_iterations(const TileCholesky& factor, const TileMatrix& matrix) {
  const double products_with_vectors = 2 * static_cast<double>(factor.tile_count() + matrix.tile_count());
  return static_cast<int>(kShareOfFactor * factor.work() * kTile / (kProductGain * products_with_vectors));
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

}  // namespace

void KeptFactor::meet(const Problem& problem) {
  unknowns_ = {};
  for (int i = 0; i < problem.poses; ++i) unknowns_.images.push_back(problem.images[i].id);
  for (const ProblemCamera& camera : problem.cameras)
    for (const int parameter : camera.free)
      unknowns_.others.push_back({kCamera, camera.id.value, static_cast<std::uint32_t>(parameter)});
  for (const AuxiliaryUnknown& auxiliary : problem.auxiliaries)
    unknowns_.others.push_back({kAuxiliary + static_cast<std::uint32_t>(auxiliary.kind), auxiliary.owner,
                                static_cast<std::uint32_t>(auxiliary.axis)});
  for (const std::uint32_t p : problem.retained_points)
    for (std::uint32_t axis = 0; axis < 3; ++axis) unknowns_.others.push_back({kRetained, problem.point(p).id, axis});
  same_structure_ = usable_ = false;
  row_.clear();
  if (!factor_ || !complete_) return;
  std::map<ImageId, int> row_of_image;
  for (std::size_t i = 0; i < factored_.images.size(); ++i) row_of_image[factored_.images[i]] = 6 * static_cast<int>(i);
  std::map<std::array<std::uint32_t, 3>, int> row_of_other;
  for (const auto& other : factored_.others)
    row_of_other.emplace(other, static_cast<int>(6 * factored_.images.size() + row_of_other.size()));
  for (const ImageId image : unknowns_.images) {
    const auto its = row_of_image.find(image);
    if (its == row_of_image.end()) return;
    for (int c = 0; c < 6; ++c) row_.push_back(its->second + c);
  }
  for (const auto& other : unknowns_.others) {
    const auto its = row_of_other.find(other);
    if (its == row_of_other.end()) return;
    row_.push_back(its->second);
  }
  usable_ = true;
}

bool KeptFactor::refresh(const TileMatrix& matrix, const TilePattern& pattern, const Run& run, double least_pivot) {
  if (!same_structure_) {
    factor_.reset();  // its memory goes first
    factor_.emplace(matrix.size(), pattern);
    factored_ = unknowns_;
    same_structure_ = true;
    row_.clear();
  }
  usable_ = complete_ = factor_->factor(matrix, run, least_pivot);
  return usable_;
}

bool KeptFactor::solve(const TileMatrix& matrix, const TilePattern& pattern, double* x, const Run& run) {
  if (usable_ && solve_by_old(matrix, x)) return true;
  if (!refresh(matrix, pattern, run, 0)) return false;
  factor_->solve(x);
  return true;
}

std::optional<TileCholesky> KeptFactor::take(const TileMatrix& matrix, const TilePattern& pattern, const Run& run,
                                             double least_pivot, int& failed_row) {
  const bool done = refresh(matrix, pattern, run, least_pivot);
  failed_row = factor_->failed_row();
  std::optional<TileCholesky> taken;
  if (done) taken = std::move(factor_);
  factor_.reset();
  same_structure_ = usable_ = false;
  return taken;
}

// z := factor^-1 r, over the unknowns that are left.
void KeptFactor::precondition(const std::vector<double>& r, std::vector<double>& z) const {
  if (row_.empty()) {
    z = r;
    factor_->solve(z.data());
    return;
  }
  std::vector<double> in_factor(static_cast<std::size_t>(factor_->tile_rows()) * kTile, 0.0);
  for (std::size_t i = 0; i < row_.size(); ++i) in_factor[row_[i]] = r[i];
  factor_->solve(in_factor.data());
  std::fill(z.begin(), z.end(), 0.0);
  for (std::size_t i = 0; i < row_.size(); ++i) z[i] = in_factor[row_[i]];
}

// What an iteration adds to the squared length of the step, in the metric of the matrix, tells how much was missing
// before it; the residual, seen by the older factor, would overlook what that factor holds too stiff.
bool KeptFactor::solve_by_old(const TileMatrix& matrix, double* x) const {
  const int most = worthwhile_iterations(*factor_, matrix);
  if (most < kFewestIterations) return false;
  const std::size_t size = static_cast<std::size_t>(matrix.tile_rows()) * kTile;
  std::vector<double> solution(size, 0.0), r(x, x + size), z(size), q(size);
  precondition(r, z);
  std::vector<double> p = z;
  double rz = dot(r, z), length = 0, last_gain = rz;
  for (int iteration = 0; iteration < most; ++iteration) {
    matrix.times(p.data(), q.data());
    const double pq = dot(p, q);
    if (!(pq > 0)) return false;
    const double along = rz / pq, gain = along * rz;
    for (std::size_t i = 0; i < size; ++i) {
      solution[i] += along * p[i];
      r[i] -= along * q[i];
    }
    length += gain;
    if (iteration > 0 && gain + last_gain <= kAccuracy * kAccuracy * length) {
      std::copy(solution.begin(), solution.end(), x);
      return true;
    }
    last_gain = gain;
    precondition(r, z);
    const double next = dot(r, z);
    for (std::size_t i = 0; i < size; ++i) p[i] = z[i] + next / rz * p[i];
    rz = next;
  }
  return false;
}

}  // namespace collinea::bundle
