// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/score_normals.h"

#include <algorithm>
#include <cmath>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/base/parallel.h"
#include "collinea/math/row_kernels.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kChunks = 8;  // of points, summed up in their order

// A' P v of observations that are no image points.
class RightSide final : public ObservationSink {
 public:
  RightSide(RowMajorMatrix& right, int column) : right_(right), column_(column) {}
  void add(const Row& row, double inverse_sigma, double residual) override {
    for (const RowPart& part : row) right_(part.row, column_) += inverse_sigma * part.derivative * residual;
  }
  void add_to_pose(int, int, double) override {}
  void add_to_right(int row, double value) override { right_(row, column_) += value; }

 private:
  RowMajorMatrix& right_;
  int column_;
};

// Derivatives by the columns of hypotheses, of kinds that have some; the residual goes without saying.
template <class Kind>
std::vector<ColumnPart> parts_of(const HypothesisColumns& columns, std::size_t item, int axis) {
  if constexpr (std::is_same_v<Kind, GnssPosition>) return columns.of_position(item, axis);
  if constexpr (std::is_same_v<Kind, Attitude>) return columns.of_attitude(item, axis);
  return {};
}

// Visits every row of a kind with the number of its item, where that is a position or an attitude.
template <class Kind, class Visit>
void for_each_numbered_row(const Problem& problem, const State& state, Visit&& visit) {
  for_each_row<Kind>(problem, state, [&](const auto& item, int axis, const ObservationRow& row) {
    std::size_t number = 0;
    if constexpr (std::is_same_v<Kind, GnssPosition>)
      number = static_cast<std::size_t>(&item - problem.positions.data());
    if constexpr (std::is_same_v<Kind, Attitude>) number = static_cast<std::size_t>(&item - problem.attitudes.data());
    visit(number, axis, row);
  });
}

}  // namespace

// A ray with its columns: functions of the pixel, which are those of the column and of the row alike, and the rest.
struct ScoreNormals::RayColumns {
  LinearRay linear;
  int slot = -1, first = 0, functions = 0;  // its camera's columns, from those of images on
  double phi[PixelFunctions::kMost];        // times weight^1/2
  int camera_unknowns = 0, first_camera = 0;
  double by_camera[2 * Camera::kAllParams];
  struct Other {
    int column;
    double value[2];
  } others[3];
  int other_count = 0;

  void add(int column, double a, double b) { others[other_count++] = {column, {a, b}}; }
  // row += by' H for one row of the transposed design with the weighted derivatives a (column) and b (row). Of
  // correlated coordinates the whitened function of the column is seen by both.
  void add_to(double* row, double a, double b) const {
    const Whitening& whitening = linear.whitening;
    const bool is_plain = whitening.is_plain();
    add_multiple(row + first, phi, is_plain ? a : a - whitening.of_column * b, functions);
    add_multiple(row + first + functions, phi, is_plain ? b : whitening.of_row * b, functions);
    for (int k = 0; k < other_count; ++k) row[others[k].column] += a * others[k].value[0] + b * others[k].value[1];
  }
};

struct ScoreNormals::Chunk {
  RowMajorMatrix right, gram;              // of the columns of images
  std::vector<Eigen::MatrixXd> functions;  // of each slot: squares of the functions alone
  // Of the point in work:
  std::vector<RayColumns> rays;
  std::vector<int> images;
  std::vector<Segment> segments;
  RowMajorMatrix by_point;  // A' H, then L^-1 A' H
};

ScoreNormals::ScoreNormals(const Solved& solved, const HypothesisColumns& columns, const TileCholesky& factor,
                           const Run& run)
    : problem_(solved.problem()),
      state_(solved.state()),
      columns_(columns),
      first_(columns.first_image_column),
      width_(columns.count() - columns.first_image_column) {
  const int unknowns = 6 * problem_.poses + problem_.global_count, all = columns.count();
  right_.setZero(unknowns, all);
  gram_.setZero(all, all);
  std::vector<Chunk> chunks(kChunks);
  const std::size_t points = problem_.point_count();
  parallel_for(run, kChunks, [&](std::size_t c) {
    chunks[c].right.setZero(unknowns, width_);
    chunks[c].gram.setZero(width_, width_);
    chunks[c].by_point.setZero(3, width_);
    chunks[c].functions.assign(columns.cameras.size(),
                               Eigen::MatrixXd::Zero(columns.functions.count(), columns.functions.count()));
    add_points(chunks[c], c * points / kChunks, (c + 1) * points / kChunks);
  });
  for (const Chunk& chunk : chunks) {
    right_.rightCols(width_) += chunk.right;
    gram_.bottomRightCorner(width_, width_) += chunk.gram;
    for (std::size_t s = 0; s < chunk.functions.size(); ++s)
      for (int k = 0; k < 2; ++k) {
        const int count = columns.functions.count(), at = columns.cameras[s].first + k * count;
        gram_.block(at, at, count, count) += chunk.functions[s];
      }
  }
  if (run.stopped()) return;
  add_given();
  gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
  solve(factor, run);
  split_groups();
}

void ScoreNormals::add_points(Chunk& chunk, std::size_t first, std::size_t end) const {
  for (std::size_t p = first; p < end; ++p) add_point(chunk, p);
}

bool ScoreNormals::take_ray(const Ray& ray, const double* position, const Loss& loss, RayColumns& out) const {
  linearise(problem_, state_, ray, position, loss, &out.linear);
  out.other_count = out.functions = out.camera_unknowns = 0;
  out.slot = -1;
  const LinearRay& linear = out.linear;
  if (linear.root_weight == 0) return false;
  const int camera = problem_.images[ray.image].camera;
  const double *a = linear.by_point, *b = linear.by_point + 3;
  if (const int slot = columns_.slot_of_camera[static_cast<std::size_t>(camera)]; slot >= 0) {
    const CameraColumns& its = columns_.cameras[static_cast<std::size_t>(slot)];
    out.slot = slot;
    out.first = its.first - first_;
    out.functions = columns_.functions.count();
    // Where the point is computed: H of measured pixels would share their errors with the residuals.
    const double* pixel = linear.at.pixel;
    columns_.functions.at(its.size, pixel, out.phi);
    for (int k = 0; k < out.functions; ++k) out.phi[k] *= linear.root_weight;
    // Rolling shutter: the camera is farther on its way when a lower row is read.
    const Eigen::Vector3d way = (pixel[1] / its.size.height_px - 0.5) * columns_.velocity[ray.image];
    out.add(out.first + 2 * out.functions, -(a[0] * way[0] + a[1] * way[1] + a[2] * way[2]),
            -(b[0] * way[0] + b[1] * way[1] + b[2] * way[2]));
  }
  // Refraction: points appear higher than they are, see raise_per_square_m.
  const double* frame = state_.frames[ray.image].data();
  const double x = position[0] - frame[9], y = position[1] - frame[10], z = position[2] - frame[11];
  const double raise = columns_.raise_per_square_m[ray.image] * (x * x + y * y + z * z);
  out.add(columns_.refraction() - first_, raise * a[2], raise * b[2]);
  out.add(columns_.residual() - first_, linear.residual[0], linear.residual[1]);
  const ProblemCamera& unknowns = problem_.cameras[static_cast<std::size_t>(camera)];
  out.camera_unknowns = static_cast<int>(unknowns.free.size());
  out.first_camera = 6 * problem_.poses + unknowns.first_global;
  if (out.camera_unknowns > 0)
    linearise_camera(linear, state_.lenses[static_cast<std::size_t>(camera)], unknowns.free, out.by_camera);
  return true;
}

// What the squares of the functions have beyond those of a round measurement: (1 + a^2, -a b; -a b, b^2) less the
// identity, times those of the functions.
void ScoreNormals::add_shape(Chunk& chunk, const RayColumns& ray) {
  const double a = ray.linear.whitening.of_column, b = ray.linear.whitening.of_row;
  const int n = ray.functions;
  for (int k = 0; k < n; ++k) {
    double* of_column = chunk.gram.row(ray.first + k).data();
    double* of_row = chunk.gram.row(ray.first + n + k).data();
    add_multiple(of_column + ray.first, ray.phi, a * a * ray.phi[k], n);
    add_multiple(of_row + ray.first, ray.phi, -a * b * ray.phi[k], n);
    add_multiple(of_row + ray.first + n, ray.phi, (b * b - 1) * ray.phi[k], n);
  }
}

void ScoreNormals::add_ray(Chunk& chunk, const RayColumns& ray, int image) const {
  const LinearRay& linear = ray.linear;
  const int n = ray.functions;
  // Squares and products of the columns.
  if (ray.slot >= 0) {
    Eigen::MatrixXd& squares = chunk.functions[static_cast<std::size_t>(ray.slot)];
    for (int k = 0; k < n; ++k) add_multiple(squares.data() + k * n, ray.phi, ray.phi[k], n);
    if (!linear.whitening.is_plain()) add_shape(chunk, ray);
  }
  for (int k = 0; k < ray.other_count; ++k)
    ray.add_to(chunk.gram.row(ray.others[k].column).data(), ray.others[k].value[0], ray.others[k].value[1]);
  // A' P H of pose, camera and point.
  if (image < problem_.poses)
    for (int c = 0; c < 3; ++c) {
      ray.add_to(chunk.right.row(6 * image + c).data(), linear.by_rotation[c], linear.by_rotation[3 + c]);
      ray.add_to(chunk.right.row(6 * image + 3 + c).data(), -linear.by_point[c], -linear.by_point[3 + c]);
    }
  for (int k = 0; k < ray.camera_unknowns; ++k)
    ray.add_to(chunk.right.row(ray.first_camera + k).data(), ray.by_camera[k], ray.by_camera[ray.camera_unknowns + k]);
  for (int c = 0; c < 3; ++c) ray.add_to(chunk.by_point.row(c).data(), linear.by_point[c], linear.by_point[3 + c]);
}

void ScoreNormals::add_point(Chunk& chunk, std::size_t p) const {
  const ProblemPoint& point = problem_.point(p);
  const Loss loss = problem_.loss_of(point);
  PointNormals normals;
  chunk.rays.clear();
  chunk.images.clear();
  chunk.segments = {{columns_.refraction() - first_, 3}};
  for (std::uint32_t r = point.first_ray; r < problem_.end_ray(p); ++r) {
    RayColumns& ray = chunk.rays.emplace_back();
    if (!take_ray(problem_.rays[r], &state_.points[3 * p], loss, ray)) {
      chunk.rays.pop_back();
      continue;
    }
    chunk.images.push_back(static_cast<int>(problem_.rays[r].image));
    normals.add(ray.linear);
    if (ray.slot >= 0 && std::ranges::none_of(chunk.segments, [&](const Segment& s) { return s.first == ray.first; }))
      chunk.segments.push_back({ray.first, columns_.per_camera()});
  }
  for (int c = 0; c < 3; ++c)
    for (const Segment& segment : chunk.segments)
      std::fill_n(chunk.by_point.row(c).data() + segment.first, segment.count, 0.0);
  for (std::size_t k = 0; k < chunk.rays.size(); ++k) add_ray(chunk, chunk.rays[k], chunk.images[k]);
  if (point.is_fixed) return;
  if (point.control >= 0) add_control(chunk, p, normals);
  if (point.first_retained < 0) return eliminate(chunk, normals);
  for (int c = 0; c < 3; ++c)
    for (const Segment& segment : chunk.segments)
      add_multiple(chunk.right.row(6 * problem_.poses + point.first_retained + c).data() + segment.first,
                   chunk.by_point.row(c).data() + segment.first, 1, segment.count);
}

// Surveyed coordinates: the bowl in their height, and their residuals.
void ScoreNormals::add_control(Chunk& chunk, std::size_t p, PointNormals& normals) const {
  const ControlCoordinates& control = problem_.control[static_cast<std::size_t>(problem_.point(p).control)];
  const double* position = &state_.points[3 * p];
  normals.add(control, position);
  const Eigen::Matrix3d weight = control.weight();
  Eigen::Vector3d residual;
  for (int c = 0; c < 3; ++c) residual[c] = weight(c, c) > 0 ? control.given[c] - position[c] : 0;
  const double bowl =
      columns_.has_bowl && weight(2, 2) > 0 ? columns_.bowl_at(Eigen::Map<const Eigen::Vector3d>(position)) : 0;
  const int b = columns_.bowl() - first_, v = columns_.residual() - first_;
  const Eigen::Vector3d weighted = weight * residual;
  chunk.by_point.col(b) += bowl * weight.col(2);
  chunk.by_point.col(v) += weighted;
  chunk.gram(b, b) += bowl * bowl * weight(2, 2);
  chunk.gram(v, b) += bowl * weighted[2];
}

// Schur complement of a point: gram -= Y' Y and right -= Z Y, with Y = L^-1 A' H and Z = W L^-T (Triggs 2000, 6.19).
void ScoreNormals::eliminate(Chunk& chunk, PointNormals normals) const {
  normals.factor(0);
  double* y[3] = {chunk.by_point.row(0).data(), chunk.by_point.row(1).data(), chunk.by_point.row(2).data()};
  for (const Segment& s : chunk.segments)
    for (int k = s.first; k < s.first + s.count; ++k) {
      double x[3] = {y[0][k], y[1][k], y[2][k]};
      normals.forward(x);
      for (int c = 0; c < 3; ++c) y[c][k] = x[c];
    }
  const auto subtract = [&](double* row, const double* z, int below) {
    for (const Segment& s : chunk.segments) {
      const int end = std::min(s.first + s.count, below);
      const double* const its[3] = {y[0] + s.first, y[1] + s.first, y[2] + s.first};
      if (end > s.first) subtract_multiples(row + s.first, its, z, end - s.first);
    }
  };
  for (const Segment& s : chunk.segments)
    for (int k = s.first; k < s.first + s.count; ++k) {
      const double z[3] = {y[0][k], y[1][k], y[2][k]};
      subtract(chunk.gram.row(k).data(), z, k + 1);
    }
  for (std::size_t r = 0; r < chunk.rays.size(); ++r) {
    const RayColumns& ray = chunk.rays[r];
    double a[6];
    std::copy_n(ray.linear.by_point, 6, a);
    normals.forward(a);
    normals.forward(a + 3);
    const auto reduce = [&](int row, double by_column, double by_row) {
      double z[3];
      for (int c = 0; c < 3; ++c) z[c] = by_column * a[c] + by_row * a[3 + c];
      subtract(chunk.right.row(row).data(), z, width_);
    };
    if (const int image = chunk.images[r]; image < problem_.poses)
      for (int c = 0; c < 3; ++c) {
        reduce(6 * image + c, ray.linear.by_rotation[c], ray.linear.by_rotation[3 + c]);
        reduce(6 * image + 3 + c, -ray.linear.by_point[c], -ray.linear.by_point[3 + c]);
      }
    for (int k = 0; k < ray.camera_unknowns; ++k)
      reduce(ray.first_camera + k, ray.by_camera[k], ray.by_camera[ray.camera_unknowns + k]);
  }
}

template <class Kind>
void ScoreNormals::add_given_kind() {
  RightSide right(right_, columns_.residual());
  Kind::for_each(problem_, [&](const auto& item) { Kind::add(problem_, state_, item, right); });
  if constexpr (std::is_same_v<Kind, GnssPosition> || std::is_same_v<Kind, Attitude>)
    for_each_numbered_row<Kind>(problem_, state_, [&](std::size_t number, int axis, const ObservationRow& row) {
      const double weight = row.weight * row.inverse_sigma * row.inverse_sigma;
      const std::vector<ColumnPart> parts = parts_of<Kind>(columns_, number, axis);
      for (const ColumnPart& part : parts) {
        for (const RowPart& by : row.derivatives)
          right_(by.row, part.column) += weight * by.derivative * part.derivative;
        for (const ColumnPart& other : parts)
          if (other.column <= part.column)
            gram_(part.column, other.column) += weight * part.derivative * other.derivative;
        gram_(columns_.residual(), part.column) += weight * part.derivative * row.residual;
      }
    });
}

void ScoreNormals::add_given() {
  for_each_kind([&]<class Kind>() {
    if constexpr (!Kind::kIsOfPoint) add_given_kind<Kind>();
  });
}

void ScoreNormals::solve(const TileCholesky& factor, const Run& run) {
  before_ = gram_;
  const auto padded = static_cast<std::size_t>(factor.tile_rows()) * kTile;
  const Eigen::Index unknowns = right_.rows(), all = right_.cols();
  solution_.resize(unknowns, all);
  parallel_for(run, static_cast<std::size_t>(all), [&](std::size_t c) {
    const auto column = static_cast<Eigen::Index>(c);
    std::vector<double> x(padded, 0.0);
    Eigen::Map<Eigen::VectorXd> solved(x.data(), unknowns);
    solved = right_.col(column);
    factor.solve(x.data());
    solution_.col(column) = solved;
  });
  gram_.noalias() -= right_.transpose() * solution_;
  gram_ = (gram_ + gram_.transpose()).eval() / 2;
}

void ScoreNormals::split_groups() {
  const int all = columns_.count();
  of_positions_.setZero(all, all);
  of_others_.setZero(all, all);
  const RowMajorMatrix solution = solution_;
  Eigen::RowVectorXd left(all);
  for_each_kind([&]<class Kind>() {
    if constexpr (!Kind::kIsOfPoint && !std::is_same_v<Kind, Vertical>) {
      Eigen::MatrixXd& sum = std::is_same_v<Kind, GnssPosition> ? of_positions_ : of_others_;
      for_each_numbered_row<Kind>(problem_, state_, [&](std::size_t number, int axis, const ObservationRow& row) {
        left.setZero();
        left[columns_.residual()] = row.residual;
        for (const ColumnPart& part : parts_of<Kind>(columns_, number, axis)) left[part.column] += part.derivative;
        for (const RowPart& by : row.derivatives) left -= by.derivative * solution.row(by.row);
        sum.noalias() += (row.weight * row.inverse_sigma * row.inverse_sigma) * left.transpose() * left;
      });
    }
  });
  add_control_residuals();
}

void ScoreNormals::add_control_residuals() {
  ControlCoordinate::for_each(problem_, [&](std::size_t p) {
    const ProblemPoint& point = problem_.point(p);
    const ControlCoordinates& control = problem_.control[static_cast<std::size_t>(point.control)];
    const Eigen::Matrix3d weight = control.weight();
    if (point.is_fixed || weight.isZero(0)) return;
    const double* position = &state_.points[3 * p];
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(3, columns_.count());
    for (int c = 0; c < 3; ++c) left(c, columns_.residual()) = weight(c, c) > 0 ? control.given[c] - position[c] : 0;
    if (columns_.has_bowl) left(2, columns_.bowl()) = columns_.bowl_at(Eigen::Map<const Eigen::Vector3d>(position));
    if (point.first_retained >= 0) {
      left -= solution_.middleRows<3>(6 * problem_.poses + point.first_retained);
    } else {
      const PointSystem system(problem_, state_, p);
      const Eigen::MatrixXd own = point_columns(p);
      for (Eigen::Index k = 0; k < left.cols(); ++k)
        left.col(k) -= system.solve_own(own.col(k)) + system.follow(solution_.col(k).data());
    }
    of_others_.noalias() += left.transpose() * weight * left;
  });
}

Eigen::MatrixXd ScoreNormals::point_columns(std::size_t p, std::vector<RayDerivatives>* rays) const {
  const ProblemPoint& point = problem_.point(p);
  const Loss loss = problem_.loss_of(point);
  Chunk chunk;
  chunk.by_point.setZero(3, width_);
  RayColumns ray;
  for (std::uint32_t r = point.first_ray; r < problem_.end_ray(p); ++r) {
    if (!take_ray(problem_.rays[r], &state_.points[3 * p], loss, ray)) continue;
    for (int c = 0; c < 3; ++c)
      ray.add_to(chunk.by_point.row(c).data(), ray.linear.by_point[c], ray.linear.by_point[3 + c]);
    if (!rays) continue;
    RowMajorMatrix its = RowMajorMatrix::Zero(2, columns_.count());
    for (int axis = 0; axis < 2; ++axis)
      ray.add_to(its.row(axis).data() + first_, axis == 0 ? 1 : 0, axis == 0 ? 0 : 1);
    // In pixels again.
    const Whitening& whitening = ray.linear.whitening;
    const auto in_pixels = [&](auto rows) {
      if (!whitening.is_plain()) rows.row(1) = (rows.row(1) + whitening.of_column * rows.row(0)) / whitening.of_row;
      return (rows / ray.linear.root_weight).eval();
    };
    using TwoRows = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
    const auto image = static_cast<int>(problem_.rays[r].image);
    const RowMajorMatrix by_camera = Eigen::Map<const RowMajorMatrix>(ray.by_camera, 2, ray.camera_unknowns);
    rays->push_back({image, problem_.images[static_cast<std::size_t>(image)].camera, in_pixels(std::move(its)),
                     in_pixels(by_camera), in_pixels(TwoRows(Eigen::Map<const TwoRows>(ray.linear.by_rotation))),
                     in_pixels(TwoRows(Eigen::Map<const TwoRows>(ray.linear.by_point)))});
  }
  PointNormals normals;
  chunk.gram.setZero(width_, width_);
  if (point.control >= 0) add_control(chunk, p, normals);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3, columns_.count());
  all.rightCols(width_) = chunk.by_point;
  return all;
}

}  // namespace collinea::bundle
