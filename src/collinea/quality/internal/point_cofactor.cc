// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/point_cofactor.h"

#include <algorithm>

#include "collinea/math/few.h"

namespace collinea::bundle {

PointSystem::PointSystem(const Problem& problem, const State& state, std::size_t p) : problem_(problem) {
  const ProblemPoint& point = problem.point(p);
  rays_.reserve(problem.end_ray(p) - point.first_ray);
  for (std::uint32_t r = point.first_ray; r < problem.end_ray(p); ++r) {
    const Ray& ray = problem.rays[r];
    LinearRay linear;
    linearise(problem, state, ray, &state.points[3 * p], problem.loss_of(point), &linear);
    add(linear, static_cast<int>(ray.image), state);
  }
  close(point.is_fixed, point.control >= 0 ? &problem.control[point.control] : nullptr, &state.points[3 * p],
        point.first_retained);
}

namespace {

// Elements of the lower triangle: neighbours lie in one tile, which is then looked up once.
class ElementReader {
 public:
  explicit ElementReader(TileCholesky& matrix) : matrix_(matrix) {}

  double at(int row, int column) {
    const int tile_row = row / kTile, tile_column = column / kTile;
    if (tile_row != tile_row_ || tile_column != tile_column_) {
      tile_ = &matrix_.at(tile_row * kTile, tile_column * kTile);
      tile_row_ = tile_row;
      tile_column_ = tile_column;
    }
    return tile_[column % kTile * kTile + row % kTile];
  }

 private:
  TileCholesky& matrix_;
  int tile_row_ = -1, tile_column_ = -1;
  const double* tile_ = nullptr;
};

}  // namespace

int PointSystem::group(int row, int count, bool is_pose) {
  for (std::size_t i = 0; i < groups_.size(); ++i)
    if (groups_[i].row == row) return static_cast<int>(i);
  groups_.push_back({row, count, width_, is_pose});
  width_ += count;
  return static_cast<int>(groups_.size()) - 1;
}

void PointSystem::add(const LinearRay& linear, int image, const State& state) {
  Measured& ray = rays_.emplace_back();
  const Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> a(linear.by_point), rotation(linear.by_rotation);
  ray.by_point = a;
  normals_.add(linear);
  if (image >= 0 && image < problem_.poses) {
    ray.pose = group(6 * image, 6, true);
    ray.by_pose << rotation, -a;
  }
  if (image >= 0) {
    const int camera = problem_.images[image].camera;
    const ProblemCamera& unknowns = problem_.cameras[camera];
    if (const auto count = static_cast<int>(unknowns.free.size()); count > 0) {
      ray.camera = group(6 * problem_.poses + unknowns.first_global, count, false);
      double b[2 * Camera::kAllParams];
      linearise_camera(linear, state.lenses[camera], unknowns.free, b);
      ray.by_camera = Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>>(b, 2, count);
    }
  }
}

void PointSystem::close(bool is_fixed, const ControlCoordinates* control, const double* position, int first_retained) {
  eliminated_ = !is_fixed && first_retained < 0;
  if (first_retained >= 0) retained_group_ = group(6 * problem_.poses + first_retained, 3, false);
  if (control) normals_.add(*control, position);
  normals_.factor(0);
  z_.setZero(width_, 3);
  if (!eliminated_) return;
  for (const Measured& ray : rays_) {
    if (ray.pose >= 0) z_.middleRows<6>(groups_[ray.pose].first) += ray.by_pose.transpose() * ray.by_point;
    if (ray.camera >= 0)
      z_.middleRows(groups_[ray.camera].first, groups_[ray.camera].count) += ray.by_camera.transpose() * ray.by_point;
  }
  for (Eigen::Index i = 0; i < z_.rows(); ++i) {
    Eigen::Vector3d row = z_.row(i);
    normals_.forward(row.data());
    z_.row(i) = row;
  }
}

bool PointSystem::determined() const {
  const double least = 1e-10 * (normals_.v[0] + normals_.v[3] + normals_.v[5]);
  return normals_.l[0] * normals_.l[0] > least && normals_.l[2] * normals_.l[2] > least &&
         normals_.l[5] * normals_.l[5] > least;
}

// The part of the inverse that belongs to the groups. A pose lies in one tile, which is looked up once. Points that are
// not eliminated tie no poses to each other, and need nothing between them.
Eigen::MatrixXd PointSystem::local(TileCholesky& inverse) const {
  Eigen::MatrixXd q(width_, width_);
  ElementReader reader(inverse);
  for (std::size_t a = 0; a < groups_.size(); ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const bool swap = groups_[a].row < groups_[b].row;
      const Group &low = swap ? groups_[b] : groups_[a], &high = swap ? groups_[a] : groups_[b];
      auto out = q.block(low.first, high.first, low.count, high.count);
      if (!eliminated_ && a != b && low.is_pose && high.is_pose)
        out.setZero();
      else if (low.is_pose && a != b)
        out =
            Eigen::Map<const Eigen::Matrix<double, 6, 6>, 0, Eigen::OuterStride<kTile>>(&inverse.at(low.row, high.row));
      else
        for (int c = 0; c < high.count; ++c)
          for (int r = 0; r < low.count; ++r)
            out(r, c) = reader.at(std::max(low.row + r, high.row + c), std::min(low.row + r, high.row + c));
      if (a != b) q.block(high.first, low.first, high.count, low.count) = out.transpose();
    }
  return q;
}

Eigen::Matrix3d PointSystem::with_own(const Eigen::Matrix3d& quadratic) const {
  Eigen::Matrix3d middle = Eigen::Matrix3d::Identity() + quadratic;
  for (int pass = 0; pass < 2; ++pass) {
    for (int c = 0; c < 3; ++c) normals_.backward(middle.col(c).data());
    middle.transposeInPlace();
  }
  return middle;
}

Eigen::Vector3d PointSystem::solve_own(Eigen::Vector3d b) const {
  normals_.forward(b.data());
  normals_.backward(b.data());
  return b;
}

Eigen::Vector3d PointSystem::follow(const double* reduced) const {
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  for (const Group& group : groups_)
    moved -= z_.middleRows(group.first, group.count).transpose() *
             Eigen::Map<const Eigen::VectorXd>(reduced + group.row, group.count);
  normals_.backward(moved.data());
  return moved;
}

void PointSystem::add_following(const Eigen::Vector3d& direction, Eigen::Ref<Eigen::VectorXd> by_reduced) const {
  Eigen::Vector3d forward = direction;  // L^-1 direction
  normals_.forward(forward.data());
  for (const Group& group : groups_)
    by_reduced.segment(group.row, group.count) -= z_.middleRows(group.first, group.count) * forward;
}

PointSystem::Relative PointSystem::relative_to(int pose, const Eigen::Vector3d& direction, TileCholesky& inverse,
                                               const double* vector) const {
  Eigen::Vector3d forward = direction;
  normals_.forward(forward.data());
  Eigen::VectorXd by_reduced = -(z_ * forward);
  Relative result;
  for (const Group& group : groups_) {
    if (group.row == 6 * pose) by_reduced.segment<3>(group.first + 3) -= direction;
    result.product += by_reduced.segment(group.first, group.count)
                          .dot(Eigen::Map<const Eigen::VectorXd>(vector + group.row, group.count));
  }
  result.variance = forward.squaredNorm() + by_reduced.dot(local(inverse) * by_reduced);
  return result;
}

Eigen::Matrix3d PointSystem::covariance(TileCholesky& inverse) const {
  if (retained_group_ >= 0) {
    Eigen::Matrix3d covariance;
    const int row = groups_[retained_group_].row;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) covariance(r, c) = inverse.at(row + std::max(r, c), row + std::min(r, c));
    return covariance;
  }
  return with_own(z_.transpose() * local(inverse) * z_);
}

Eigen::Matrix3d PointSystem::covariance_by_solving(const TileCholesky& factor) const {
  const auto rows = static_cast<std::size_t>(factor.tile_rows() * kTile);
  Eigen::Matrix<double, Eigen::Dynamic, 3> solved(width_, 3);
  for (int c = 0; c < 3; ++c) {
    std::vector<double> x(rows, 0.0);
    for (const Group& group : groups_)
      for (int i = 0; i < group.count; ++i) x[static_cast<std::size_t>(group.row + i)] = z_(group.first + i, c);
    factor.solve(x.data());
    for (const Group& group : groups_)
      for (int i = 0; i < group.count; ++i) solved(group.first + i, c) = x[static_cast<std::size_t>(group.row + i)];
  }
  return with_own(z_.transpose() * solved);
}

// With C = A L^-T the adjusted measurement moves by (J - C Z') dx and by its own C: (J - C Z') Q (J - C Z')' + C C'.
std::vector<Eigen::Matrix2d> PointSystem::leverages(TileCholesky& inverse) const {
  const Eigen::MatrixXd q = local(inverse);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> qz = q * z_;
  const Eigen::Matrix3d own = Eigen::Matrix3d::Identity() + z_.transpose() * qz;
  std::vector<Eigen::Matrix2d> all;
  all.reserve(rays_.size());
  struct Part {
    const Group* group = nullptr;
    Design design;
  };
  Few<Part, 3> parts;
  for (const Measured& ray : rays_) {
    Eigen::Matrix<double, 2, 3> c = ray.by_point;
    for (int row = 0; row < 2; ++row) {
      Eigen::Vector3d forward = c.row(row);
      normals_.forward(forward.data());
      c.row(row) = forward;
    }
    if (!eliminated_) c.setZero();
    parts.count = 0;
    if (ray.pose >= 0) parts.add({&groups_[ray.pose], ray.by_pose});
    if (ray.camera >= 0) parts.add({&groups_[ray.camera], ray.by_camera});
    if (retained_group_ >= 0) parts.add({&groups_[retained_group_], ray.by_point});
    Eigen::Matrix2d leverage = c * own * c.transpose();
    for (const Part& one : parts) {
      const Eigen::Matrix2d mixed = one.design * qz.middleRows(one.group->first, one.group->count) * c.transpose();
      leverage -= mixed + mixed.transpose();
      for (const Part& other : parts)
        leverage += one.design * q.block(one.group->first, other.group->first, one.group->count, other.group->count) *
                    other.design.transpose();
    }
    all.push_back(leverage);
  }
  return all;
}

}  // namespace collinea::bundle
