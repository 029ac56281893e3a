// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/datum_defect.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "collinea/adjust/gauge.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/math/median.h"

namespace collinea::bundle {
namespace {

using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr std::size_t kDatumImages = 8, kLeastDatumCandidates = 64;
constexpr double kSeen = 1e-9;  // of the largest eigenvalue: 3e-5 in angle or relative scale

// Images connected by points, as numbers of parts; held images belong to every part and join nothing.
std::vector<int> parts_of(const Problem& problem, std::vector<int>& part_of_point, int& parts) {
  std::vector<int> root(problem.poses);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (std::size_t p = 0; p < problem.point_count(); ++p) {
    if (problem.point(p).held) continue;
    const std::uint32_t first = problem.point(p).first_free;
    for (std::uint32_t r = first; r < problem.end_ray(p); ++r) {
      const int a = find(problem.rays[first].image), b = find(problem.rays[r].image);
      root[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<int> part(problem.poses, -1);
  parts = 0;
  for (int i = 0; i < problem.poses; ++i) part[i] = find(i) == i ? parts++ : part[find(i)];
  part_of_point.assign(problem.point_count(), -1);
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (problem.point(p).first_free < problem.end_ray(p))
      part_of_point[p] = part[problem.rays[problem.point(p).first_free].image];
  return part;
}

struct Part {
  std::vector<int> poses;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double size = 1;
  Matrix7 seen = Matrix7::Zero();  // which motions something observes
  bool held = false, positions = false, control = false, verticals = false, ground = false;

  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& axes = Eigen::Vector3d::Ones()) {
    const Matrix37 g = axes.asDiagonal() * motion_of(point, centre, size);
    seen += g.transpose() * g;
  }
};

// The size is that of the part's bases or, when there are none to speak of, the distance of its points.
void measure(std::vector<Part>& parts, const Problem& problem, const State& state, const std::vector<int>& part) {
  std::vector<std::vector<double>> distances(parts.size());
  for (Part& one : parts)
    for (const int pose : one.poses) one.centre += centre_in(state, pose) / double(one.poses.size());
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (const std::uint32_t ray = problem.point(p).first_free; ray < problem.end_ray(p)) {
      const int its = part[problem.rays[ray].image];
      distances[its].push_back((Eigen::Vector3d(&state.points[3 * p]) - parts[its].centre).norm());
    }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double squared = 0, distance = 1;
    for (const int pose : parts[i].poses) squared += (centre_in(state, pose) - parts[i].centre).squaredNorm();
    if (!distances[i].empty()) distance = median(distances[i]);
    parts[i].size = std::sqrt(squared / double(parts[i].poses.size()));
    if (!(parts[i].size > 1e-3 * distance)) parts[i].size = distance > 0 ? distance : 1;
  }
}

void gather_observed_motions(const Problem& problem, const State& state, const std::vector<int>& part,
                             const std::vector<int>& part_of_point, std::vector<Part>& parts) {
  for (const GivenPosition& position : problem.positions) {
    if (!position.plain()) continue;
    Part& its = parts[part[position.image]];
    its.add(centre_in(state, position.image), (position.inverse_sigma.array() > 0).cast<double>());
    its.positions = true;
  }
  for (const GivenUp& given : problem.verticals) {  // turns about the two level axes
    Part& its = parts[part[given.image]];
    its.seen.diagonal().segment<2>(3).array() += 1;
    its.verticals = true;
  }
  for (std::size_t p = 0; p < problem.point_count(); ++p) {
    if (part_of_point[p] < 0) continue;
    Part& its = parts[part_of_point[p]];
    const ProblemPoint& point = problem.point(p);
    const Eigen::Vector3d place = Eigen::Map<const Eigen::Vector3d>(&state.points[3 * p]);
    if (point.held) {
      for (std::uint32_t r = point.first_free; r < problem.end_ray(p); ++r) {
        Part& seeing = parts[part[problem.rays[r].image]];
        seeing.add(place);
        seeing.held = true;
      }
    } else if (point.control >= 0) {
      const double* inverse_sigma = problem.control[point.control].inverse_sigma;
      its.add(place, (Eigen::Map<const Eigen::Array3d>(inverse_sigma) > 0).cast<double>());
      its.control |= Eigen::Map<const Eigen::Array3d>(inverse_sigma).maxCoeff() > 0;
    }
    if (point.first_ray < point.first_free &&
        !point.held) {  // seen by held images: their rays fix the point's direction
      for (std::uint32_t r = point.first_ray; r < point.first_free; ++r) {
        const Eigen::Vector3d ray = (place - centre_in(state, problem.rays[r].image)).normalized();
        const Matrix37 g =
            (Eigen::Matrix3d::Identity() - ray * ray.transpose()) * motion_of(place, its.centre, its.size);
        its.seen += g.transpose() * g;
      }
      its.held = true;
    }
  }
}

// A point that measurements on the ground alone determine: its unknowns are like those of set-ups.
bool is_unseen(const Problem& problem, std::uint32_t point) {
  return problem.point(point).first_ray == problem.end_ray(point);
}

// Points that no image shows belong to the part of those they are measured to.
void extend_parts(const Problem& problem, std::vector<int>& part_of_point) {
  for (bool found = true; found;) {
    found = false;
    for (const GeodeticLink& link : problem.ground)
      for (const auto& [a, b] : {std::pair(link.from, link.to), std::pair(link.to, link.from)})
        if (part_of_point[a] >= 0 && part_of_point[b] < 0 && is_unseen(problem, b)) {
          part_of_point[b] = part_of_point[a];
          found = true;
        }
  }
}

// Observations by unknowns of their own see what these leave: their rows by the motions and by those unknowns.
class SeenWithAuxiliaries {
 public:
  SeenWithAuxiliaries(const Problem& problem, std::size_t parts) : problem_(problem) {
    for (std::size_t k = 0; k < problem.auxiliaries.size(); ++k)
      add_column(problem.first_extra + static_cast<int>(k), problem.auxiliaries[k].inverse_sigma > 0);
    for (const std::uint32_t p : problem.joined) {
      const ProblemPoint& point = problem.point(p);
      if (!is_unseen(problem, p)) continue;
      for (int c = 0; c < 3; ++c)
        add_column(point.joined + c, problem.control[static_cast<std::size_t>(point.control)].inverse_sigma[c] > 0);
    }
    normals_.assign(parts, Eigen::MatrixXd::Zero(7 + count(), 7 + count()));
  }
  /// `row` may hold other unknowns too, which are those that the motions stand for.
  void add(int part, const Eigen::Matrix<double, 1, 7>& motions, const Row& row) {
    Eigen::RowVectorXd all = Eigen::RowVectorXd::Zero(7 + count());
    all.head<7>() = motions;
    for (const RowPart& one : row)
      if (const auto k = column_.find(one.row - 6 * problem_.poses); k != column_.end())
        all[7 + k->second] += one.derivative;
    if (all.squaredNorm() > 0) normals_[part] += all.transpose() * all;
  }
  /// What the motions keep when the extras may be anything that their own observations allow. What is left of a motion
  /// by rounding alone is nothing.
  [[nodiscard]] Matrix7 seen(int part) const {
    Eigen::MatrixXd n = normals_[part];
    Matrix7 seen = n.topLeftCorner<7, 7>();
    if (count() == 0) return seen;
    const double whole = seen.trace();
    for (int k = 0; k < count(); ++k)
      if (observed_[static_cast<std::size_t>(k)]) n(7 + k, 7 + k) += std::max(1.0, n(7 + k, 7 + k));
    const Eigen::VectorXd scale = n.diagonal().tail(count()).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd own = scale.asDiagonal() * n.bottomRightCorner(count(), count()) * scale.asDiagonal();
    const Eigen::MatrixXd coupling = n.topRightCorner(7, count()) * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(own);
    for (int k = 0; k < count(); ++k) {
      if (!(eigen.eigenvalues()[k] > kSeen)) continue;
      const Eigen::Matrix<double, 7, 1> along = coupling * eigen.eigenvectors().col(k);
      seen -= along * along.transpose() / eigen.eigenvalues()[k];
    }
    const Eigen::SelfAdjointEigenSolver<Matrix7> left(seen);
    const Eigen::Matrix<double, 7, 1> values =
        (left.eigenvalues().array() > kSeen * whole).select(left.eigenvalues(), 0.0);
    return left.eigenvectors() * values.asDiagonal() * left.eigenvectors().transpose();
  }

 private:
  [[nodiscard]] int count() const { return static_cast<int>(observed_.size()); }
  void add_column(int in_border, bool observed) {
    column_[in_border] = count();
    observed_.push_back(observed);
  }

  const Problem& problem_;
  std::map<int, int> column_;  // by the place in the border
  std::vector<bool> observed_;
  std::vector<Eigen::MatrixXd> normals_;
};

// Which motions of its part a measurement on the ground, an antenna or an attitude sees, as far as its direction goes.
void gather_other_motions(const Problem& problem, const State& state, const std::vector<int>& part,
                          std::vector<Part>& parts) {
  const std::vector<int>& part_of_point = problem.part_of_point;
  SeenWithAuxiliaries all(problem, parts.size());
  for (const GeodeticLink& link : problem.ground) {
    const int its = part_of_point[link.from];
    if (!(link.inverse_sigma > 0) || its < 0 || its != part_of_point[link.to]) continue;
    const Part& one = parts[its];
    const GeodeticModel model = model_of(problem, link, state);
    Eigen::Matrix<double, 1, 7> seen = Eigen::Matrix<double, 1, 7>::Zero();
    for (const auto& [point, derivative] : {std::pair(link.from, &model.by_from), std::pair(link.to, &model.by_to)})
      if (!is_unseen(problem, point))
        seen += derivative->transpose() * motion_of(Eigen::Vector3d(&state.points[3ul * point]), one.centre, one.size);
    Row row = row_of(problem, link, model);
    if (const double length = seen.norm(); length > 0) {
      seen /= length;
      for (RowPart& entry : row) entry.derivative = entry.row < 6 * problem.poses ? 0 : entry.derivative / length;
    }
    all.add(its, seen, row);
    parts[its].ground = true;
  }
  for (const GivenPosition& position : problem.positions) {
    if (position.plain()) continue;
    Part& its = parts[part[position.image]];
    const Matrix37 motions = motion_of(centre_in(state, position.image), its.centre, its.size);
    for (int axis = 0; axis < 3; ++axis)
      if (position.inverse_sigma[axis] > 0)
        all.add(part[position.image], motions.row(axis), row_of(problem, state, position, axis));
    its.positions = true;
  }
  for (const GivenTurn& given : problem.attitudes) {
    for (int axis = 0; axis < 3; ++axis)  // a world turned by w turns cam_from_world by -w in the world
      if (given.inverse_sigma[axis] > 0)
        all.add(part[given.image], -Eigen::Matrix<double, 1, 7>::Unit(3 + axis), row_of(problem, state, given, axis));
    parts[part[given.image]].verticals |= given.inverse_sigma.maxCoeff() > 0;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].seen += all.seen(static_cast<int>(i));
}

// Up to kDatumImages poses of the part, each as far as possible from those before; of a large part among those that are
// eliminated last, where the ties between them cost nothing.
std::vector<int> spread_poses(const Part& part, const State& state) {
  const auto last = static_cast<std::size_t>(4 * std::sqrt(static_cast<double>(part.poses.size())));
  const std::size_t candidates = std::min(part.poses.size(), std::max(kLeastDatumCandidates, last));
  const std::vector<int> poses(part.poses.end() - static_cast<std::ptrdiff_t>(candidates), part.poses.end());
  std::vector<double> distance(poses.size());
  for (std::size_t i = 0; i < distance.size(); ++i) distance[i] = (centre_in(state, poses[i]) - part.centre).norm();
  std::vector<int> chosen;
  while (chosen.size() < std::min(kDatumImages, poses.size())) {
    const auto far = std::max_element(distance.begin(), distance.end()) - distance.begin();
    chosen.push_back(poses[far]);
    for (std::size_t i = 0; i < distance.size(); ++i)
      distance[i] = std::min(distance[i], (centre_in(state, poses[i]) - centre_in(state, poses[far])).norm());
    distance[far] = -1;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// The motion `unseen` of the whole part as a motion of single poses; inner product in units of angle and size.
DatumConstraint constraint(const Part& part, const State& state, const std::vector<int>& poses,
                           const Eigen::Matrix<double, 7, 1>& unseen) {
  DatumConstraint result{poses, {}, {}, part.centre, part.size, 0};
  double squared = 0;
  for (const int pose : poses) {
    // A world turned by w turns cam_from_world by -R w in the camera frame.
    const Eigen::Vector3d turn = -(state.rotations[pose] * unseen.segment<3>(3));
    const Eigen::Vector3d shift = motion_of(centre_in(state, pose), part.centre, part.size) * unseen / part.size;
    result.direction.push_back({turn.x(), turn.y(), turn.z(), shift.x(), shift.y(), shift.z()});
    squared += turn.squaredNorm() + shift.squaredNorm() * part.size * part.size;
  }
  for (auto& direction : result.direction)
    for (double& value : direction) value /= std::sqrt(squared);
  return result;
}

DatumSources sources_of(const std::vector<Part>& parts) {
  DatumSources sources;
  for (const Part& part : parts) {
    sources.ground |= part.ground;
    sources.fixed |= part.held;
    sources.positions |= part.positions;
    sources.control |= part.control;
    sources.attitudes |= part.verticals;
  }
  sources.parts = static_cast<int>(parts.size());
  return sources;
}

}  // namespace

void find_datum(Problem& problem, const State& start) {
  int count = 0;
  std::vector<int> part_of_point;
  const std::vector<int> part = parts_of(problem, part_of_point, count);
  problem.part_of_pose = part;
  std::vector<Part> parts(count);
  for (int i = 0; i < problem.poses; ++i) parts[part[i]].poses.push_back(i);
  measure(parts, problem, start, part);
  gather_observed_motions(problem, start, part, part_of_point, parts);
  extend_parts(problem, part_of_point);
  problem.part_of_point = std::move(part_of_point);
  if (!problem.auxiliaries.empty() || !problem.ground.empty() || !problem.attitudes.empty())
    gather_other_motions(problem, start, part, parts);
  for (const Part& one : parts) {
    problem.extent_m = std::max(problem.extent_m, one.size);
    const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(one.seen);
    const double largest = std::max(eigen.eigenvalues()[6], 1e-300);
    const std::vector<int> poses = spread_poses(one, start);
    for (int k = 0; k < 7 && eigen.eigenvalues()[k] <= kSeen * largest; ++k) {
      problem.datum.push_back(constraint(one, start, poses, eigen.eigenvectors().col(k)));
      problem.datum.back().motion = eigen.eigenvectors().col(k);
      problem.datum.back().part = static_cast<int>(&one - parts.data());
      ++problem.rank_defect;
    }
  }
  // Nothing of it is held, also no station on the ground that no image shows.
  bool held = false;
  for (std::size_t p = 0; p < problem.point_count(); ++p) held = held || problem.point(p).held;
  problem.moves_as_one = parts.size() == 1 && !held && problem.images.size() == parts.front().poses.size();
  problem.datum_sources = sources_of(parts);
}

}  // namespace collinea::bundle
