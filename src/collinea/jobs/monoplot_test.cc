// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/monoplot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/jobs/internal/village_pair_for_tests.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

using testing::kVillageFocal_px;
using testing::VillagePair;

// A village with the orientation of its left photograph and the raster of a slope that it looks down on.
struct Plotted : VillagePair {
  static constexpr double kCell_m = 0.5;
  Eigen::Vector3d centre = centre_of(pose(0));

  [[nodiscard]] double height(double x, double y) const {
    return 2 + 0.125 * (x - std::floor(centre.x())) - 0.0625 * (y - std::floor(centre.y()));
  }
  void write_raster(const std::string& name, float value) const {
    const int side = 200;
    const MapGrid grid{std::floor(centre.x()) - 50, std::floor(centre.y()) + 50, kCell_m, side, side, ""};
    FloatImage cells(side, side, 1);
    for (int row = 0; row < side; ++row)
      for (int column = 0; column < side; ++column)
        cells.at(column, row) = value > 0 ? value : float(height(grid.east_of(column + 0.5), grid.north_of(row + 0.5)));
    auto writer = GeoTiffWriter<float>::create(folder / name, grid, 1, {.nodata = -9999});
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->write(0, 0, cells));
    ASSERT_TRUE(writer->finish());
  }
  void write_tables() const {
    const OmegaPhiKappa angles = omega_phi_kappa(pose(0).rotation);
    ASSERT_TRUE(
        write_file(folder / "exterior.txt",
                   "image X[m] Y[m] Z[m] omega[deg] phi[deg] kappa[deg] sigma_X[m] sigma_Y[m] sigma_Z[m]\n" +
                       fmt::format("IMG_0001 {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} 0.02 0.02 0.04\n", centre.x(),
                                   centre.y(), centre.z(), angles.omega_deg, angles.phi_deg, angles.kappa_deg)));
    std::string marks = "image point x[px] y[px] sigma[px]\n";
    const Camera& camera = truth.cameras.begin()->second;
    for (int i = 0; i < 9; ++i) {
      const Eigen::Vector3d at = point(i);
      const auto seen = project(camera, pose(0) * at);
      ASSERT_TRUE(seen);
      marks += fmt::format("IMG_0001.jpg P{} {:.9f} {:.9f} 0.5\n", i, seen->x(), seen->y());
    }
    ASSERT_TRUE(write_file(folder / "marks.txt", marks + "other.jpg Q 100 100 0.5\n"));
  }
  [[nodiscard]] Eigen::Vector3d point(int i) const {
    const double x = centre.x() + 11.0 * (i % 3 - 1), y = centre.y() + 7.5 * (i / 3 - 1);
    return {x, y, height(x, y)};
  }
};

TEST(MonoplotJob, FindsGroundPointsOfASlope) {
  const Plotted scene;
  scene.write_raster("slope.tif", 0);
  scene.write_raster("sigma.tif", 0.25F);
  scene.write_tables();
  MonoplotTableOptions options;
  options.photo.principal_distance = kVillageFocal_px;
  options.photo.principal_point = "400,300";
  options.surface_sigma = scene.folder / "sigma.tif";
  const auto report = monoplot_from_tables(scene.folder / "marks.txt", scene.folder / "exterior.txt",
                                           scene.folder / "slope.tif", options, {});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->points.size(), 10u);
  EXPECT_FALSE(report->points[9].is_oriented);
  EXPECT_TRUE(report->orientations_have_sigmas);
  for (int i = 0; i < 9; ++i) {
    const MonoplotPoint& found = report->points[std::size_t(i)].found;
    ASSERT_EQ(found.outcome, MonoplotOutcome::kFound) << i;
    EXPECT_LT((found.position - scene.point(i)).norm(), 1e-6);  // nine decimals of pixels and metres
    EXPECT_EQ(found.height_sigma_m, 0.25);
    // Half a pixel of 0.1 m and 2 cm of the position, and what a height of 0.25 m off shifts it.
    EXPECT_GT(std::sqrt(found.covariance(0, 0)), 0.05);
    EXPECT_LT(std::sqrt(found.covariance(0, 0)), 0.2);
  }
  const std::string text = monoplot_text(*report);
  EXPECT_NE(text.find("9 of 10 rays meet the surface"), text.npos) << text;
  EXPECT_NE(text.find("no orientation of image other.jpg"), text.npos) << text;
  EXPECT_EQ(monoplot_tables(*report)[0].table.rows.size(), 10u);
}

// Where a shift along x goes with a rotation about y that undoes it, a point below is known better than by the shift.
TEST(MonoplotJob, CorrelationsOfTheOrientationCount) {
  const Plotted scene;
  scene.write_raster("slope.tif", 0);
  scene.write_tables();
  MonoplotTableOptions options;
  options.photo.principal_distance = kVillageFocal_px;
  options.photo.principal_point = "400,300";
  const Eigen::Vector3d middle = scene.point(4);
  const double sigma_deg = 0.5 / (scene.centre.z() - middle.z()) * 180 / std::numbers::pi;  // half a metre below
  const OmegaPhiKappa angles = omega_phi_kappa(scene.pose(0).rotation);
  const auto variance = [&](double correlation) {
    EXPECT_TRUE(
        write_file(scene.folder / "poses.txt",
                   "image X[m] Y[m] Z[m] omega[deg] phi[deg] kappa[deg] sigma_X[m] sigma_phi[deg] correlation_X_phi\n" +
                       fmt::format("IMG_0001 {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} 0.5 {:.12f} {}\n",
                                   scene.centre.x(), scene.centre.y(), scene.centre.z(), angles.omega_deg,
                                   angles.phi_deg, angles.kappa_deg, sigma_deg, correlation)));
    const auto report = monoplot_from_tables(scene.folder / "marks.txt", scene.folder / "poses.txt",
                                             scene.folder / "slope.tif", options, {});
    EXPECT_TRUE(report) << report.error().message;
    return report ? report->points[4].found.covariance(0, 0) : 0;
  };
  const double none = variance(0), against = variance(0.9), along = variance(-0.9);
  // Var(a + b) = a2 + b2 + 2 r a b: the measurement adds the same to all three.
  EXPECT_NEAR(against + along, 2 * none, 1e-9);
  EXPECT_GT(std::abs(against - along), 0.9 * none);
}

TEST(MonoplotJob, TellsWhatIsMissing) {
  const Plotted scene;
  scene.write_raster("slope.tif", 0);
  scene.write_tables();
  MonoplotTableOptions options;
  const auto plot = [&](const char* surface) {
    return monoplot_from_tables(scene.folder / "marks.txt", scene.folder / "exterior.txt", scene.folder / surface,
                                options, {});
  };
  EXPECT_FALSE(plot("slope.tif"));  // no principal distance
  options.photo.principal_distance = kVillageFocal_px;
  EXPECT_TRUE(plot("slope.tif"));
  EXPECT_FALSE(plot("none.tif"));
  options.surface_sigma = scene.folder / "none.tif";
  const auto sigma = plot("slope.tif");
  ASSERT_FALSE(sigma);
  EXPECT_EQ(sigma.error().options.front().name, "surface_sigma");
}

}  // namespace
}  // namespace collinea
