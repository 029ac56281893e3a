// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/intersection.h"
#include "collinea/jobs/resection.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct View {
  const char* name;
  CardanAngles angles;
  Vector3d centre;
};

// Two images of 150 mm, resected from 15 exact points and intersected in a new one, 80 seeds. Their orientations
// are independent, so that e' C^-1 e of the point is chi-squared with 3 degrees of freedom: its mean scatters by
// sqrt(6 / 80). Without the correlations of the orientations, -0.99 between centre and angle, it is 0.2.
TEST(ResectionIntersection, PointsOfResectedImagesAreAsFarOffAsStated) {
  constexpr int kSeeds = 80;
  constexpr double kSigma_mm = 0.005;
  const TestFolder folder;
  const std::array<View, 2> images = {
      {{"L", {0.02, -0.03, 0.1}, {-150, 10, 900}}, {"R", {-0.01, 0.04, 0.12}, {160, -20, 910}}}};
  const Vector3d target(20, 60, 40);
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed);
    std::string marks = "image point x[mm] y[mm] sigma[mm]\n", ground = "point X[m] Y[m] Z[m]\n", of_target = marks;
    const auto measured = [&](const View& view, const std::string& name, const Vector3d& point) {
      const Vector3d seen = rotation_matrix(view.angles) * (point - view.centre);
      const Vector2d xy = -150 * seen.head<2>() / seen.z() + kSigma_mm * Vector2d(random.normal(), random.normal());
      return std::string(view.name) + " " + name + " " + exact(xy.x()) + " " + exact(xy.y()) + " 0.005\n";
    };
    for (int i = 0; i < 15; ++i) {
      const Vector3d point(random.uniform(-350, 350), random.uniform(-400, 400), random.uniform(0, 150));
      ground += std::to_string(i) + " " + exact(point.x()) + " " + exact(point.y()) + " " + exact(point.z()) + "\n";
      for (const View& view : images) marks += measured(view, std::to_string(i), point);
    }
    for (const View& view : images) of_target += measured(view, "new", target);
    const auto file = [&](const char* name, const std::string& text) {
      EXPECT_TRUE(write_file(folder / name, text));
      return folder / name;
    };
    ResectOneOptions options;
    options.photo.principal_distance = 150;
    const auto resected = resect_from_tables(file("m.txt", marks), file("g.txt", ground), options);
    ASSERT_TRUE(resected) << resected.error().message;
    IntersectTableOptions of_rays;
    of_rays.photo.principal_distance = 150;
    const TextTable orientation = resection_tables(*resected).front().table;
    const auto found = intersect_from_tables(file("t.txt", of_target), file("o.txt", text_of(orientation)), of_rays);
    ASSERT_TRUE(found) << found.error().message;
    const Vector3d error = found->points[0].position - target;
    sum += error.dot(found->points[0].covariance.ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kSeeds, 3, 4 * std::sqrt(6.0 / kSeeds));
}

}  // namespace
}  // namespace collinea
