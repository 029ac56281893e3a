// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/control_similarity.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

constexpr int kStarts = 60;  // rotations, evenly drawn: one lies within 45 degrees of any
constexpr int kMostSteps = 30;
constexpr double kLeastRatio = 1e-8;  // of eigenvalues of the normal matrix with coordinates of unit extent
constexpr double kAlike = 1.05;       // RMS of two attitudes that fit alike

// Normal equations of dX = eps X' + omega x X' + tau, with X' from the centroid in units of the extent.
struct Normals {
  Matrix7d matrix = Matrix7d::Zero();
  Vector7d right = Vector7d::Zero();
  Vector3d centre = Vector3d::Zero();
  double extent = 1, squares = 0;
};

Normals normals_of(const std::vector<ControlPair>& pairs, const Similarity3& ground_from_model) {
  Normals n;
  for (const ControlPair& pair : pairs) n.centre += ground_from_model * pair.in_model / double(pairs.size());
  double spread = 0;
  for (const ControlPair& pair : pairs)
    spread += (ground_from_model * pair.in_model - n.centre).squaredNorm() / double(pairs.size());
  n.extent = spread > 0 ? std::sqrt(spread) : 1;
  for (const ControlPair& pair : pairs) {
    const Vector3d x = ground_from_model * pair.in_model, reduced = (x - n.centre) / n.extent;
    Eigen::Matrix<double, 3, 7> a;
    a << reduced, -skew(reduced), Matrix3d::Identity();
    const Vector3d l = pair.on_ground - x;
    for (int axis = 0; axis < 3; ++axis) {
      if (!pair.has[static_cast<std::size_t>(axis)]) continue;
      n.matrix += a.row(axis).transpose() * a.row(axis);
      n.right += a.row(axis).transpose() * l[axis];
      n.squares += l[axis] * l[axis];
    }
  }
  return n;
}

int rank_of(const Matrix7d& matrix) {
  const Vector7d values = Eigen::SelfAdjointEigenSolver<Matrix7d>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  return static_cast<int>((values.array() > kLeastRatio * std::max(values.maxCoeff(), 1e-300)).count());
}

Similarity3 stepped(const Similarity3& from, const Normals& n, const Vector7d& step) {
  const double factor = std::exp(step[0] / n.extent);
  const Eigen::Quaterniond turn = rotation_by(step.segment<3>(1) / n.extent);
  return {factor * from.scale, (turn * from.rotation).normalized(),
          n.centre + factor * (turn * (from.translation - n.centre)) + step.tail<3>()};
}

// Scale and translation for a given rotation: linear.
std::optional<Similarity3> start_with(const std::vector<ControlPair>& pairs, const Eigen::Quaterniond& rotation) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const ControlPair& pair : pairs) {
    const Vector3d turned = rotation * pair.in_model;
    for (int axis = 0; axis < 3; ++axis) {
      if (!pair.has[static_cast<std::size_t>(axis)]) continue;
      Eigen::Vector4d row = Eigen::Vector4d::Zero();
      row[0] = turned[axis];
      row[1 + axis] = 1;
      matrix += row * row.transpose();
      right += row * pair.on_ground[axis];
    }
  }
  const Eigen::Vector4d x = matrix.completeOrthogonalDecomposition().solve(right);
  if (!x.allFinite() || !(x[0] > 0)) return std::nullopt;
  return Similarity3{x[0], rotation, x.tail<3>()};
}

struct Fit {
  Similarity3 ground_from_model;
  double squares = 0;
  int rank = 0;
};

// Levenberg-Marquardt.
Fit refined(const std::vector<ControlPair>& pairs, Similarity3 at) {
  double damping = 1e-3;
  Normals n = normals_of(pairs, at);
  for (int step = 0; step < kMostSteps; ++step) {
    Matrix7d matrix = n.matrix;
    matrix.diagonal() *= 1 + damping;
    matrix.diagonal().array() += 1e-12 * n.matrix.trace();
    const Vector7d by = matrix.ldlt().solve(n.right);
    const Similarity3 tried = stepped(at, n, by);
    Normals next = normals_of(pairs, tried);
    if (!(next.squares <= n.squares)) {
      damping *= 10;
      if (damping > 1e6) break;
      continue;
    }
    const bool settled = by.norm() < 1e-12 * n.extent;
    at = tried;
    n = next;
    damping /= 10;
    if (settled) break;
  }
  return {at, n.squares, rank_of(n.matrix)};
}

}  // namespace

ControlRank rank_of(const std::vector<ControlPair>& pairs, const Similarity3& ground_from_model) {
  ControlRank found;
  for (const ControlPair& pair : pairs) {
    found.plan += pair.has[0] && pair.has[1];
    found.heights += pair.has[2];
  }
  if (!pairs.empty()) found.rank = rank_of(normals_of(pairs, ground_from_model).matrix);
  return found;
}

std::optional<Similarity3> control_similarity(const std::vector<ControlPair>& pairs) {
  std::vector<Vector3d> in_model, on_ground;
  for (const ControlPair& pair : pairs)
    if (pair.has[0] && pair.has[1] && pair.has[2]) {
      in_model.push_back(pair.in_model);
      on_ground.push_back(pair.on_ground);
    }
  if (const auto direct = align(in_model, on_ground)) {
    const Fit fit = refined(pairs, *direct);
    if (fit.rank == 7) return fit.ground_from_model;
  }
  Random random(1);
  std::vector<Fit> fits;
  double extent_squared = 0;
  for (int start = 0; start < kStarts; ++start) {
    const double w = random.normal(), x = random.normal(), y = random.normal(), z = random.normal();
    const Eigen::Quaterniond drawn = Eigen::Quaterniond(w, x, y, z).normalized();
    const auto from = start_with(pairs, start == 0 ? Eigen::Quaterniond::Identity() : drawn);
    if (!from) continue;
    const Fit fit = refined(pairs, *from);
    if (fit.rank == 7 && fit.ground_from_model.scale > 1e-9 * from->scale) fits.push_back(fit);
  }
  for (const ControlPair& pair : pairs) extent_squared += (pair.in_model - pairs.front().in_model).squaredNorm();
  if (fits.empty()) return std::nullopt;
  double least = fits.front().squares;
  for (const Fit& fit : fits) least = std::min(least, fit.squares);
  const double scale = fits.front().ground_from_model.scale;
  const double limit = kAlike * least + 1e-14 * scale * scale * extent_squared;
  const Fit* best = nullptr;
  double best_up = -2;
  for (const Fit& fit : fits) {
    const double up = (fit.ground_from_model.rotation * Vector3d::UnitZ()).z();
    if (fit.squares > limit || up < best_up + 1e-6) continue;
    best = &fit;
    best_up = up;
  }
  return best->ground_from_model;
}

}  // namespace collinea
