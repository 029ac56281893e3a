// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "collinea/adjust/observation_kinds.h"
#include "collinea/base/parallel.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kRaysInBatch = 4096;
constexpr std::size_t kMostChunks = 16;                    // of a batch
constexpr std::size_t kGlobalSums = std::size_t{1} << 24;  // of all chunks: 128 MB

// Tiles whose images share a point or a datum constraint; the rows of the cameras are full.
TilePattern pattern_of(const Problem& problem) {
  const auto rows = static_cast<std::size_t>((6 * problem.poses + problem.global_count + kTile - 1) / kTile);
  std::vector<std::vector<bool>> occupied(rows);
  for (std::size_t i = 0; i < rows; ++i) occupied[i].resize(i + 1);
  std::vector<int> tiles;
  const auto tie_all = [&] {
    for (std::size_t a = 0; a < tiles.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b) occupied[std::max(tiles[a], tiles[b])][std::min(tiles[a], tiles[b])] = true;
    tiles.clear();
  };
  const auto add = [&](int pose) {
    const int tile = pose / kPosesOfTile;
    if (tiles.empty() || tiles.back() != tile) tiles.push_back(tile);
  };
  for (std::size_t p = 0; p < problem.point_count(); ++p) {
    if (!problem.point(p).eliminated()) continue;
    for (std::uint32_t r = problem.point(p).first_free; r < problem.end_ray(p); ++r)
      add(static_cast<int>(problem.rays[r].image));
    tie_all();
  }
  for (const DatumConstraint& datum : problem.datum) {
    for (const int pose : datum.poses) add(pose);
    tie_all();
  }
  TilePattern pattern(rows);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (occupied[i][k] || (problem.global_count > 0 && static_cast<int>(i + 1) * kTile > 6 * problem.poses))
        pattern[i].push_back(static_cast<int>(k));
  return pattern;
}

void keep(const LinearRay& linear, PoseRay& out) {
  for (int row = 0; row < 2; ++row)
    for (int c = 0; c < 3; ++c) {
      out.j[6 * row + c] = linear.by_rotation[3 * row + c];
      out.j[6 * row + 3 + c] = -linear.by_point[3 * row + c];
    }
  out.residual[0] = linear.residual[0];
  out.residual[1] = linear.residual[1];
}

// Z = J^T A L^-T and r -= A L^-T y; every row of A is solved forward, and A is minus J by the centre.
void reduce(const PointNormals& normals, const double* y, PoseRay& ray) {
  double a[6];
  for (int row = 0; row < 2; ++row) {
    double* at = a + 3 * row;
    for (int c = 0; c < 3; ++c) at[c] = -ray.j[6 * row + 3 + c];
    normals.forward(at);
    ray.residual[row] -= at[0] * y[0] + at[1] * y[1] + at[2] * y[2];
  }
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 6; ++i) ray.z[6 * k + i] = ray.j[i] * a[k] + ray.j[6 + i] * a[3 + k];
}

}  // namespace

Normals::Normals(const Problem& problem, KeptFactor& kept)
    : problem_(problem),
      kept_(kept),
      pattern_(pattern_of(problem)),
      matrix_(6 * problem.poses + problem.global_count, pattern_) {
  kept_.meet(problem);
  right_.resize(static_cast<std::size_t>(matrix_.tile_rows()) * kTile);
  diagonal_.resize(right_.size());
  pose_camera_.resize(6ul * static_cast<std::size_t>(problem.poses) * static_cast<std::size_t>(problem.global_count));
  for (const ProblemCamera& camera : problem.cameras)
    widest_camera_ = std::max(widest_camera_, static_cast<int>(camera.free.size()));
  cut_batches();
  index_rows();
  const auto global_count = static_cast<std::size_t>(problem.global_count);
  chunks_.resize(
      std::clamp<std::size_t>(kGlobalSums / std::max<std::size_t>(1, global_count * global_count), 1, kMostChunks));
  for (GlobalSums& sums : chunks_) {
    sums.matrix.resize(global_count * global_count);
    sums.right.resize(global_count);
    sums.diagonal.resize(global_count);
  }
}

void Normals::cut_batches() {
  std::size_t largest = 0, most_cameras = 0;
  const std::size_t points = problem_.point_count();
  camera_begin_.push_back(0);
  for (std::size_t p = 0; p < points; ++p) {
    const auto begin = cameras_of_point_.end() - cameras_of_point_.begin();
    for (std::uint32_t r = problem_.point(p).first_ray; r < problem_.end_ray(p); ++r) {
      const int camera = problem_.images[problem_.rays[r].image].camera;
      if (!problem_.cameras[camera].free.empty() &&
          std::find(cameras_of_point_.begin() + begin, cameras_of_point_.end(), camera) == cameras_of_point_.end())
        cameras_of_point_.push_back(camera);
    }
    camera_begin_.push_back(static_cast<std::uint32_t>(cameras_of_point_.size()));
  }
  for (std::size_t p = 0; p < points;) {
    const std::size_t first = p;
    while (p < points && problem_.end_ray(p) - problem_.point(first).first_ray <= kRaysInBatch) ++p;
    p = std::max(p, first + 1);
    batches_.push_back({first, p});
    largest = std::max<std::size_t>(largest, problem_.point(p).first_ray - problem_.point(first).first_ray);
    most_cameras = std::max<std::size_t>(most_cameras, camera_begin_[p] - camera_begin_[first]);
  }
  pose_rays_.resize(largest);
  camera_rays_.resize(2ul * largest * static_cast<std::size_t>(widest_camera_));
  camera_points_.resize(3ul * most_cameras * static_cast<std::size_t>(widest_camera_));
}

void Normals::index_rows() {
  const auto poses = static_cast<std::uint32_t>(problem_.poses);
  first_of_ray_.resize(problem_.rays.size());
  point_of_ray_.resize(problem_.rays.size());
  std::vector<std::uint32_t> count(static_cast<std::size_t>(matrix_.tile_rows()), 0);
  for (Batch& batch : batches_) {
    std::vector<int> rows;
    const auto each_ray = [&](auto&& take) {
      for (std::uint32_t r = problem_.point(batch.first_point).first_ray; r < problem_.point(batch.end_point).first_ray;
           ++r)
        if (problem_.rays[r].image < poses) take(r, static_cast<int>(problem_.rays[r].image) / kPosesOfTile);
    };
    each_ray([&](std::uint32_t, int row) {
      if (count[row]++ == 0) rows.push_back(row);
    });
    std::sort(rows.begin(), rows.end());
    batch.first_row = batch_rows_.size();
    auto next = static_cast<std::uint32_t>(row_rays_.size());
    for (const int row : rows) {
      batch_rows_.push_back({row, next, next + count[row]});
      next += std::exchange(count[row], batch_rows_.back().first_ray);  // from here on: where the next ray goes
    }
    batch.end_row = batch_rows_.size();
    row_rays_.resize(next);
    each_ray([&](std::uint32_t r, int row) { row_rays_[count[row]++] = r; });
    for (const int row : rows) count[row] = 0;
    for (std::size_t p = batch.first_point; p < batch.end_point; ++p)
      for (std::uint32_t r = problem_.point(p).first_ray; r < problem_.end_ray(p); ++r) {
        first_of_ray_[r] = problem_.point(p).eliminated() ? problem_.point(p).first_free : r + 1;  // or no partners
        point_of_ray_[r] = static_cast<std::uint32_t>(p);
      }
  }
}

// The normal equations as a sink of observations.
class Normals::Sink final : public ObservationSink {
 public:
  explicit Sink(Normals& normals) : normals_(normals) {}
  void add(const Row& row, double inverse_sigma, double residual) override {
    normals_.add_observation(row, inverse_sigma, residual);
  }
  void add_to_pose(int row, int column, double value) override {
    normals_.matrix_.at(row, column) += value;
    if (row == column) normals_.diagonal_[static_cast<std::size_t>(row)] += value;
  }
  void add_to_right(int row, double value) override { normals_.right_[static_cast<std::size_t>(row)] += value; }

 private:
  Normals& normals_;
};

template <class Kind>
double Normals::add_kind(const State& state) {
  double cost = 0;
  Sink sink(*this);
  Kind::for_each(problem_, [&](const auto& item) { cost += Kind::add(problem_, state, item, sink); });
  return cost;
}

double Normals::accumulate(const State& state, double lambda, const Run& run, double datum_stiffness) {
  matrix_.clear();
  std::fill(right_.begin(), right_.end(), 0.0);
  std::fill(diagonal_.begin(), diagonal_.end(), 0.0);
  std::fill(pose_camera_.begin(), pose_camera_.end(), 0.0);
  for (GlobalSums& sums : chunks_) {
    std::fill(sums.matrix.begin(), sums.matrix.end(), 0.0);
    std::fill(sums.right.begin(), sums.right.end(), 0.0);
    std::fill(sums.diagonal.begin(), sums.diagonal.end(), 0.0);
    sums.cost = 0;
  }
  Run serial;
  const Run& threads = problem_.rays.size() >= kRaysWorthThreads ? run : serial;
  for (std::size_t b = 0; b < batches_.size() && !run.stopped(); ++b) {
    parallel_for(threads, chunks_.size(),
                 [&](std::size_t chunk) { linearise_points(state, lambda, batches_[b], chunk); });
    parallel_for(threads, batches_[b].end_row - batches_[b].first_row,
                 [&](std::size_t row) { add_row(batches_[b], batch_rows_[batches_[b].first_row + row]); });
  }
  global_sums_ = chunks_[0];
  for (std::size_t c = 1; c < chunks_.size(); ++c) {
    for (std::size_t i = 0; i < global_sums_.matrix.size(); ++i) global_sums_.matrix[i] += chunks_[c].matrix[i];
    for (std::size_t i = 0; i < global_sums_.right.size(); ++i) global_sums_.right[i] += chunks_[c].right[i];
    for (std::size_t i = 0; i < global_sums_.right.size(); ++i) global_sums_.diagonal[i] += chunks_[c].diagonal[i];
    global_sums_.cost += chunks_[c].cost;
  }
  double cost = global_sums_.cost;
  for_each_kind([&]<class Kind>() {
    if constexpr (Kind::kIsOfPoint)
      cost += add_retained(state);
    else
      cost += add_kind<Kind>(state);
  });
  add_datum(datum_stiffness);
  assemble(lambda);
  return cost;
}

void Normals::linearise_points(const State& state, double lambda, const Batch& batch, std::size_t chunk) {
  const std::size_t count = batch.end_point - batch.first_point;
  const std::size_t first = batch.first_point + count * chunk / chunks_.size();
  const std::size_t end = batch.first_point + count * (chunk + 1) / chunks_.size();
  for (std::size_t p = first; p < end; ++p) linearise_point(state, lambda, batch, p, chunks_[chunk]);
}

void Normals::linearise_point(const State& state, double lambda, const Batch& batch, std::size_t p, GlobalSums& sums) {
  const ProblemPoint& point = problem_.point(p);
  const Loss loss = problem_.loss_of(point);
  const std::uint32_t base = problem_.point(batch.first_point).first_ray;
  const auto width = static_cast<std::size_t>(widest_camera_);
  PointNormals normals;
  CostSum cost(loss);
  double* zc = camera_points_.data() + 3ul * (camera_begin_[p] - camera_begin_[batch.first_point]) * width;
  std::fill(zc, zc + 3 * (camera_begin_[p + 1] - camera_begin_[p]) * width, 0.0);

  for (std::uint32_t r = point.first_ray; r < problem_.end_ray(p); ++r) {
    const Ray& ray = problem_.rays[r];
    const int camera = problem_.images[ray.image].camera;
    LinearRay linear;
    cost.add(linearise(ray, state.frames[ray.image], state.lenses[camera], &state.points[3 * p], loss, &linear));
    if (point.eliminated()) normals.add(linear);
    if (r >= point.first_free) keep(linear, pose_rays_[r - base]);
    if (problem_.cameras[camera].free.empty()) continue;
    double* b = camera_rays_.data() + 2ul * (r - base) * width;
    linearise_camera(linear, state.lenses[camera], problem_.cameras[camera].free, b);
    double* its_zc = zc;
    for (const int* its = cameras_of_point_.data() + camera_begin_[p]; *its != camera; ++its) its_zc += 3 * width;
    add_camera_ray(linear, problem_.cameras[camera], b, point.eliminated() ? its_zc : nullptr, sums);
  }
  sums.cost += cost.value();
  if (!point.eliminated()) {
    for (std::uint32_t r = point.first_free; r < problem_.end_ray(p); ++r)
      std::fill(std::begin(pose_rays_[r - base].z), std::end(pose_rays_[r - base].z), 0.0);
    return;
  }
  if (point.control >= 0) sums.cost += normals.add(problem_.control[point.control], &state.points[3 * p]);
  normals.factor(lambda);
  double y[3] = {normals.right[0], normals.right[1], normals.right[2]};
  normals.forward(y);
  for (std::uint32_t r = point.first_free; r < problem_.end_ray(p); ++r) reduce(normals, y, pose_rays_[r - base]);
  reduce_cameras(p, normals, y, batch, sums);
}

// Camera normals of one ray: matrix += B^T B, right += B^T r, and Wc += B^T A of its point (if it is eliminated).
void Normals::add_camera_ray(const LinearRay& linear, const ProblemCamera& camera, const double* b, double* wc,
                             GlobalSums& sums) const {
  const std::size_t count = camera.free.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double b0 = b[i], b1 = b[count + i];
    if (wc)
      for (int c = 0; c < 3; ++c) wc[3 * i + c] += b0 * linear.by_point[c] + b1 * linear.by_point[3 + c];
    const std::size_t row = static_cast<std::size_t>(camera.first_global) + i;
    sums.right[row] += b0 * linear.residual[0] + b1 * linear.residual[1];
    sums.diagonal[row] += b0 * b0 + b1 * b1;
    double* out = &sums.matrix[row * static_cast<std::size_t>(problem_.global_count) +
                               static_cast<std::size_t>(camera.first_global)];
    for (std::size_t k = 0; k <= i; ++k) out[k] += b0 * b[k] + b1 * b[count + k];
  }
}

// Eliminates the point from the equations of the cameras: Zc = Wc L^-T; matrix -= Zc Zc'^T, right -= Zc y.
void Normals::reduce_cameras(std::size_t p, const PointNormals& normals, const double* y, const Batch& batch,
                             GlobalSums& sums) {
  const auto global_count = static_cast<std::size_t>(problem_.global_count),
             width = static_cast<std::size_t>(widest_camera_);
  double* zc = camera_points_.data() + 3ul * (camera_begin_[p] - camera_begin_[batch.first_point]) * width;
  const int* cameras = cameras_of_point_.data() + camera_begin_[p];
  const std::size_t count = camera_begin_[p + 1] - camera_begin_[p];
  for (std::size_t a = 0; a < count; ++a) {
    const ProblemCamera& one = problem_.cameras[cameras[a]];
    for (std::size_t i = 0; i < one.free.size(); ++i) {
      double* z = zc + 3 * (a * width + i);
      normals.forward(z);
      sums.right[static_cast<std::size_t>(one.first_global) + i] -= z[0] * y[0] + z[1] * y[1] + z[2] * y[2];
    }
  }
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b) {
      const ProblemCamera &one = problem_.cameras[cameras[a]], &other = problem_.cameras[cameras[b]];
      if (other.first_global > one.first_global) continue;
      for (std::size_t i = 0; i < one.free.size(); ++i) {
        const double* z = zc + 3 * (a * width + i);
        double* out = &sums.matrix[(static_cast<std::size_t>(one.first_global) + i) * global_count +
                                   static_cast<std::size_t>(other.first_global)];
        const std::size_t end = a == b ? i + 1 : other.free.size();
        for (std::size_t k = 0; k < end; ++k) {
          const double* q = zc + 3 * (b * width + k);
          out[k] -= z[0] * q[0] + z[1] * q[1] + z[2] * q[2];
        }
      }
    }
}

void Normals::add_row(const Batch& batch, const BatchRow& row) {
  thread_local std::vector<double*> tile_of;  // by tile column; only those of this row are looked at
  thread_local std::vector<double*> blocks;
  tile_of.resize(std::max(tile_of.size(), static_cast<std::size_t>(row.tile_row) + 1));
  double* tile = matrix_.tile(matrix_.first(row.tile_row));
  for (const int column : matrix_.columns(row.tile_row)) {
    tile_of[static_cast<std::size_t>(column)] = tile;
    tile += kTileSize;
  }
  for (std::uint32_t s = row.first_ray; s < row.end_ray; ++s) {
    add_pose_ray(batch, row_rays_[s], tile_of.data(), blocks);
    if (problem_.global_count > 0) add_pose_cameras(batch, row_rays_[s]);
  }
}

void Normals::add_pose_ray(const Batch& batch, std::uint32_t r, double* const* tile_of, std::vector<double*>& blocks) {
  const std::uint32_t base = problem_.point(batch.first_point).first_ray;
  const PoseRay& ray = pose_rays_[r - base];
  const std::uint32_t pose = problem_.rays[r].image;
  const auto block_of = [&](std::uint32_t other) {
    return tile_of[other / kPosesOfTile] + 6 * (other % kPosesOfTile * kTile + pose % kPosesOfTile);
  };
  blocks.clear();
  for (std::uint32_t other = first_of_ray_[r]; other <= r; ++other)
    blocks.push_back(block_of(problem_.rays[other].image));
  bundle::add_pose_ray(ray, block_of(pose), &right_[6ul * pose], &diagonal_[6ul * pose], blocks.data(),
                       blocks.empty() ? nullptr : &pose_rays_[first_of_ray_[r] - base],
                       static_cast<int>(blocks.size()));
}

void Normals::add_pose_cameras(const Batch& batch, std::uint32_t r) {
  const std::uint32_t base = problem_.point(batch.first_point).first_ray;
  const PoseRay& ray = pose_rays_[r - base];
  const std::uint32_t image = problem_.rays[r].image, p = point_of_ray_[r];
  const auto width = static_cast<std::size_t>(widest_camera_);
  double* out = &pose_camera_[6ul * image * static_cast<std::size_t>(problem_.global_count)];
  const ProblemCamera& own = problem_.cameras[problem_.images[image].camera];
  const double* b = camera_rays_.data() + 2ul * (r - base) * width;
  add_pose_camera(out + 6 * own.first_global, ray, b, static_cast<int>(own.free.size()));
  if (!problem_.point(p).eliminated()) return;
  const double* z = camera_points_.data() + 3ul * (camera_begin_[p] - camera_begin_[batch.first_point]) * width;
  for (std::uint32_t its = camera_begin_[p]; its < camera_begin_[p + 1]; ++its, z += 3 * width) {
    const ProblemCamera& camera = problem_.cameras[cameras_of_point_[its]];
    subtract_pose_camera(out + 6 * camera.first_global, ray, z, static_cast<int>(camera.free.size()));
  }
}

void Normals::add_to_globals(int row, int column, double value) {
  global_sums_
      .matrix[static_cast<std::size_t>(std::max(row, column)) * static_cast<std::size_t>(problem_.global_count) +
              static_cast<std::size_t>(std::min(row, column))] += value;
}

// Points that keep their unknowns: what their rays say of images and cameras alone is there already.
double Normals::add_retained(const State& state) {
  double cost = 0;
  for (const std::uint32_t p : problem_.retained_points) {
    const ProblemPoint& point = problem_.point(p);
    const double* position = &state.points[3ul * p];
    PointNormals normals;
    for (std::uint32_t r = point.first_ray; r < problem_.end_ray(p); ++r) {
      const Ray& ray = problem_.rays[r];
      const int camera = problem_.images[ray.image].camera;
      LinearRay linear;
      linearise(ray, state.frames[ray.image], state.lenses[camera], position, problem_.loss_of(point), &linear);
      normals.add(linear);
      const double *a = linear.by_point, *rotation = linear.by_rotation;
      for (int c = 0; c < 3; ++c) {
        if (static_cast<int>(ray.image) < problem_.poses) {
          double* out = &pose_camera_[6ul * (std::size_t{ray.image} * static_cast<std::size_t>(problem_.global_count) +
                                             static_cast<std::size_t>(point.first_retained + c))];
          for (int i = 0; i < 3; ++i) {
            out[i] += rotation[i] * a[c] + rotation[3 + i] * a[3 + c];
            out[3 + i] -= a[i] * a[c] + a[3 + i] * a[3 + c];
          }
        }
        const ProblemCamera& unknowns = problem_.cameras[camera];
        double b[2 * Camera::kAllParams];
        linearise_camera(linear, state.lenses[camera], unknowns.free, b);
        const std::size_t count = unknowns.free.size();
        for (std::size_t k = 0; k < count; ++k)
          add_to_globals(point.first_retained + c, unknowns.first_global + static_cast<int>(k),
                         a[c] * b[k] + a[3 + c] * b[count + k]);
      }
    }
    cost += normals.add(problem_.control[point.control], position);
    constexpr int kElement[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (int c = 0; c < 3; ++c) {
      const auto row = static_cast<std::size_t>(point.first_retained + c);
      for (int k = 0; k <= c; ++k)
        add_to_globals(point.first_retained + c, point.first_retained + k, normals.v[kElement[c][k]]);
      global_sums_.right[row] += normals.right[c];
      global_sums_.diagonal[row] += normals.v[kElement[c][c]];
    }
  }
  return cost;
}

// One observation by its row; `residual` has its weight already.
void Normals::add_observation(const Row& row, double weight, double residual) {
  const int globals_begin = 6 * problem_.poses;
  for (const RowPart& one : row) {
    const double d = one.derivative * weight;
    const bool is_pose = one.row < globals_begin;
    (is_pose ? right_[static_cast<std::size_t>(one.row)]
             : global_sums_.right[static_cast<std::size_t>(one.row - globals_begin)]) += d * residual;
    (is_pose ? diagonal_[static_cast<std::size_t>(one.row)]
             : global_sums_.diagonal[static_cast<std::size_t>(one.row - globals_begin)]) += d * d;
    for (const RowPart& other : row) {
      if (other.row > one.row) continue;
      const double product = d * other.derivative * weight;
      if (is_pose)
        matrix_.at(one.row, other.row) += product;
      else if (other.row >= globals_begin)
        add_to_globals(one.row - globals_begin, other.row - globals_begin, product);
      else
        pose_camera_[6ul * (static_cast<std::size_t>(other.row / 6) * static_cast<std::size_t>(problem_.global_count) +
                            static_cast<std::size_t>(one.row - globals_begin)) +
                     static_cast<std::size_t>(other.row % 6)] += product;
    }
  }
}

// A heavy weight on motions that no observation sees: it changes which of many equal solutions is taken, not the
// residuals.
void Normals::add_datum(double stiffness) {
  for (const DatumConstraint& datum : problem_.datum) {
    double known = 0;
    for (const int pose : datum.poses)
      for (int c = 0; c < 3; ++c) known += diagonal_[6ul * static_cast<std::size_t>(pose) + c];
    const double weight = stiffness * known / (3 * double(datum.poses.size()));
    for (std::size_t a = 0; a < datum.poses.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        double* block = &matrix_.at(6 * datum.poses[a], 6 * datum.poses[b]);
        for (int c = 0; c < 6; ++c)
          for (int i = 0; i < 6; ++i) block[c * kTile + i] += weight * datum.direction[a][i] * datum.direction[b][c];
      }
  }
}

void Normals::assemble(double lambda) {
  const int first = 6 * problem_.poses, global_count = problem_.global_count;
  for (int k = 0; k < global_count; ++k) {
    const int row = first + k;
    for (int pose = 0; pose < problem_.poses; ++pose)
      for (int c = 0; c < 6; ++c)
        matrix_.at(row, 6 * pose + c) = pose_camera_[6ul * (static_cast<std::size_t>(pose) * global_count + k) + c];
    for (int i = 0; i <= k; ++i)
      matrix_.at(row, first + i) = global_sums_.matrix[static_cast<std::size_t>(k) * global_count + i];
    right_[static_cast<std::size_t>(row)] = global_sums_.right[k];
    diagonal_[static_cast<std::size_t>(row)] = global_sums_.diagonal[k];
  }
  for (int i = 0; i < matrix_.size(); ++i) matrix_.at(i, i) += lambda * diagonal_[static_cast<std::size_t>(i)];
}

bool Normals::solve(const Run& run, Step& step) {
  step.reduced = right_;
  if (!kept_.solve(matrix_, pattern_, step.reduced.data(), run)) return false;
  step.squared_length = std::inner_product(right_.begin(), right_.end(), step.reduced.begin(), 0.0);
  return std::all_of(step.reduced.begin(), step.reduced.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace collinea::bundle
