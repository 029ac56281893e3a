// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/given_pair.h"

#include <fmt/format.h>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

constexpr double kStep = 1e-6;  // of a derivative [rad, bases]

Rigid3 motion_of(const Rigid3& first, const Rigid3& second) {
  Rigid3 motion = second * inverse(first);
  motion.translation.normalize();
  return motion;
}

double distance(const std::array<Rigid3, 2>& poses) { return (centre_of(poses[1]) - centre_of(poses[0])).norm(); }

// The change (changed()) that leads from one motion to another near it.
Vector5 change_between(const Rigid3& from, const Rigid3& to) {
  const Eigen::Vector3d base = base_in_first(from);
  Vector5 change;
  change << rotation_vector((to.rotation * from.rotation.conjugate()).normalized()),
      tangents_of(base).transpose() * (base_in_first(to) - base);
  return change;
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Of [changed(), base].
Matrix6 covariance_of(const GivenPair& pair) {
  Matrix6 sum = Matrix6::Zero();
  for (std::size_t k = 0; k < 2; ++k) {
    Matrix6 by;
    for (int i = 0; i < 6; ++i) {
      const double step = i < 3 ? kStep : kStep * pair.base;
      std::array<Rigid3, 2> more{pair.poses[0].cam_from_world, pair.poses[1].cam_from_world}, less = more;
      more[k] = pose_after(more[k], i, step);
      less[k] = pose_after(less[k], i, -step);
      by.col(i).head<5>() = (change_between(pair.second_from_first, motion_of(more[0], more[1])) -
                             change_between(pair.second_from_first, motion_of(less[0], less[1]))) /
                            (2 * step);
      by(5, i) = (distance(more) - distance(less)) / (2 * step);
    }
    sum += by * pair.poses[k].covariance * by.transpose();
  }
  return sum;
}

}  // namespace

std::optional<GivenPair> pair_of_poses(const UncertainPose& left, const UncertainPose& right) {
  GivenPair pair;
  pair.poses = {left, right};
  pair.base = distance({left.cam_from_world, right.cam_from_world});
  if (!(pair.base > 0)) return std::nullopt;
  pair.second_from_first = motion_of(left.cam_from_world, right.cam_from_world);
  pair.covariance_with_base = covariance_of(pair);
  pair.covariance = pair.covariance_with_base.topLeftCorner<5, 5>();
  return pair;
}

AbsoluteOrientation GivenPair::ground_from_model() const {
  AbsoluteOrientation made;
  made.ground_from_model = {1, poses[0].cam_from_world.rotation.conjugate(), centre_of(poses[0].cam_from_world)};
  return made;
}

Rigid3 pose_after(const Rigid3& cam_from_world, int parameter, double step) {
  Eigen::Vector3d centre = centre_of(cam_from_world);
  Rigid3 made = cam_from_world;
  if (parameter < 3)
    made.rotation =
        (cam_from_world.rotation * rotation_by(step * Eigen::Vector3d::Unit(parameter)).conjugate()).normalized();
  else
    centre[parameter - 3] += step;
  made.translation = -(made.rotation * centre);
  return made;
}

Result<GivenPair> read_given_pair(const std::filesystem::path& left, const std::filesystem::path& right,
                                  const PairChainOptions& options) {
  if (options.control || options.base_m)
    return fail(Errc::kBadInput, "the table of exterior orientations states the base and where the ground is",
                {"exterior"_option, "control"_option, "base_m"_option});
  COLLINEA_TRY(const ExteriorTable table, read_exterior_table(*options.exterior));
  std::array<UncertainPose, 2> poses;
  const std::filesystem::path* const files[] = {&left, &right};
  const std::array<std::string, 2> words{"left", "right"};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::array<std::string, 3> names{files[k]->filename().string(), words[k], "film_" + words[k]};
    const UncertainPose* found = table.find(names);
    if (!found)
      return fail(Errc::kNotFound, fmt::format("{}: no image {}", options.exterior->string(), names[0]),
                  {"exterior"_option});
    poses[k] = *found;
  }
  auto pair = pair_of_poses(poses[0], poses[1]);
  if (!pair)
    return fail(Errc::kIllPosed, options.exterior->string() + ": both images have the same projection centre",
                {"exterior"_option});
  pair->is_metric = table.is_metric;
  return *std::move(pair);
}

}  // namespace collinea
