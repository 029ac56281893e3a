// SPDX-License-Identifier: Apache-2.0
// Times the start of a resection by P3P, and judges covariances of absolute orientation and resection over many seeds;
// times of the adjustments are in speed.cc.
// usage: collinea_bench_single_image
#include <Eigen/Cholesky>
#include <chrono>
#include <cstdio>

#include "collinea/geometry/absolute_orientation.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"
#include "collinea/orient/space_resection.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d random_vector(Random& random, double size) {
  return {size * random.normal(), size * random.normal(), size * random.normal()};
}

template <class Work>
double milliseconds(int times, const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < times; ++i) work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count() / times;
}

std::vector<AbsoluteControl> control(int count, const Similarity3& truth, std::uint64_t seed) {
  Random random(seed);
  std::vector<AbsoluteControl> pairs;
  for (int i = 0; i < count; ++i) {
    AbsoluteControl pair;
    pair.in_model = random_vector(random, 100);
    pair.in_ground = truth * pair.in_model + random_vector(random, 0.03);
    pair.in_model += random_vector(random, 0.05);
    pair.model_covariance = 0.0025 * Eigen::Matrix3d::Identity();
    pair.ground_covariance = 0.0009 * Eigen::Matrix3d::Identity();
    pairs.push_back(pair);
  }
  return pairs;
}

struct Photograph {
  Camera camera = ideal_camera(4000, 4000, 3000);
  Rigid3 pose;
  std::vector<Vector2d> pixels;
  std::vector<Vector3d> truth;
  std::vector<ResectionMark> marks;
  std::vector<ResectionPoint> points;

  Photograph(int count, double sigma_m, std::uint64_t seed) {
    Random random(seed);
    pose.rotation = cam_from_world({3 * random.normal(), 3 * random.normal(), 60 * random.normal()});
    pose.translation = -(pose.rotation * (Vector3d(0, 0, 100) + random_vector(random, 2)));
    for (int i = 0; i < count; ++i) {
      truth.push_back({20 * random.normal(), 15 * random.normal(), 4 * random.normal()});
      pixels.push_back(*project(camera, pose * truth.back()) + 0.7 * Vector2d(random.normal(), random.normal()));
      marks.push_back({0, std::size_t(i), pixels.back(), 0.7});
      points.push_back({truth.back() + random_vector(random, sigma_m), Vector3d::Constant(sigma_m)});
    }
  }
  [[nodiscard]] double chi2(const SpaceResection& found) const {
    Eigen::Matrix<double, 6, 1> error;
    error << rotation_vector(found.cam_from_world[0].rotation.conjugate() * pose.rotation),
        centre_of(found.cam_from_world[0]) - centre_of(pose);
    return error.dot(found.covariance.ldlt().solve(error));
  }
};

void times() {
  const Photograph photo(1000, 0.03, 2);
  std::printf("1000 points, start by P3P, 40 and 500 triples: %.3f and %.3f ms\n",
              milliseconds(20, [&] { (void)pose_starts(photo.camera, photo.pixels, photo.truth, 1, 40); }),
              milliseconds(5, [&] { (void)pose_starts(photo.camera, photo.pixels, photo.truth, 1, 500); }));
}

void covariances() {
  constexpr int kSeeds = 2000;
  double sum = 0, resection = 0;
  int inside = 0, resection_inside = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), 9);
    const Similarity3 truth{std::exp(0.3 * random.normal()), rotation_by(random_vector(random, 1)), {1e5, 2e5, 300}};
    const auto found = absolute_orientation(control(8, truth, static_cast<std::uint64_t>(seed)));
    if (!found) continue;
    Eigen::Matrix<double, 7, 1> error;
    error << found->ground_from_model * found->centroid_in_model - truth * found->centroid_in_model,
        rotation_vector(found->ground_from_model.rotation * truth.rotation.conjugate()),
        std::log(found->ground_from_model.scale / truth.scale);
    const double chi2 = error.dot(found->covariance.ldlt().solve(error));
    sum += chi2 / 7 / kSeeds;
    inside += chi2 < 14.067;
    const Photograph photo(8, 0.03, static_cast<std::uint64_t>(seed));
    const auto pose = space_resection(photo.camera, std::vector<Rigid3>{photo.pose}, photo.marks, photo.points);
    if (!pose) continue;
    resection += photo.chi2(*pose) / 6 / kSeeds;
    resection_inside += photo.chi2(*pose) < 12.592;
  }
  std::printf("%d seeds, eight points: mean of chi2 over degrees of freedom, share within the 95 %% bound\n", kSeeds);
  std::printf("  absolute   %.3f  %.1f %%\n", sum, 100.0 * inside / kSeeds);
  std::printf("  resection  %.3f  %.1f %%\n", resection, 100.0 * resection_inside / kSeeds);
}

}  // namespace
}  // namespace collinea

int main() {
  collinea::times();
  collinea::covariances();
  return 0;
}
