// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/plotted_vertex.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/base/test_folder.h"
#include "collinea/marking/test_marking.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::images_of;
using testing::marking_scene;
using testing::MarkingScene;

constexpr double kRelative_m = 0.03, kCell_m = 0.5, kClick_m = 0.1, kMark_px = 0.5;

/// A plane through two positions, level across the way from one to the other.
struct Plane {
  Vector3d at;
  Vector2d slope;
  Plane(const Vector3d& a, const Vector3d& b) : at(a) {
    const Vector2d way = (b - a).head<2>();
    slope = (b.z() - a.z()) / way.squaredNorm() * way;
  }
  [[nodiscard]] double height(double x, double y) const { return at.z() + slope.dot(Vector2d(x, y) - at.head<2>()); }
};

Result<> write_raster(const std::filesystem::path& file, const MapGrid& grid,
                      const std::function<double(double, double)>& value) {
  FloatImage cells(grid.width, grid.height, 1);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) cells.at(x, y) = float(value(grid.east_of(x + 0.5), grid.north_of(y + 0.5)));
  COLLINEA_TRY(auto writer, GeoTiffWriter<float>::create(file, grid, 1, {.nodata = -9999}));
  COLLINEA_TRY(writer.write(0, 0, cells));
  return writer.finish();
}

Result<PlottingSurface> surface_of(const TestFolder& folder, const Plane& plane) {
  const MapGrid grid{plane.at.x() - 100, plane.at.y() + 100, kCell_m, 400, 400, ""};
  COLLINEA_TRY(write_raster(folder / "dsm.tif", grid, [&](double x, double y) { return plane.height(x, y); }));
  COLLINEA_TRY(write_raster(folder / "dsm_sigma.tif", grid, [](double, double) { return 2 * kRelative_m; }));
  COLLINEA_TRY(write_raster(folder / "dsm_sigma_relative.tif", grid, [](double, double) { return kRelative_m; }));
  return PlottingSurface::open(folder / "dsm.tif");
}

// Where the block as adjusted sees a point that its images show exactly: what dense matching makes of it.
std::optional<Vector3d> seen_by_block(const MarkingScene& scene, ControlId id) {
  std::vector<std::pair<double, ImageId>> images;
  for (const OrientedImage& one : oriented_images(scene.block))
    if (scene.seen(one.image, id))
      images.emplace_back((centre_of(one.cam_from_world) - scene.points.at(id)).norm(), one.image);
  std::sort(images.begin(), images.end());
  std::vector<SightLine> lines;
  for (std::size_t i = 0; i < std::min(images.size(), VertexPlotter::kNearest); ++i)
    lines.push_back({&scene.block.camera_of(images[i].second),
                     pose_of(scene.block, images[i].second),
                     *scene.seen(images[i].second, id),
                     1,
                     {}});
  const auto found = intersect(lines);
  return found ? std::optional(found->point_in_world) : std::nullopt;
}

std::vector<ImageMark> marks_of(const MarkingScene& scene, ControlId id, std::size_t count, Random& random) {
  std::vector<ImageMark> marks;
  for (const ImageId image : images_of(scene, id, random)) {
    if (marks.size() == count) break;
    marks.push_back({image, scene.mark(image, id, kMark_px, random).pixel, kMark_px});
  }
  return marks;
}

struct MeanSquare {
  double sum = 0;
  int count = 0;
  void add(const VectorXd& error, const Eigen::MatrixXd& covariance) {
    sum += error.dot(covariance.ldlt().solve(error));
    ++count;
  }
  // Chi-squared with n degrees has the mean n and the variance 2 n: four standard deviations leave one false alarm in
  // 16,000.
  void expect(int degrees, const char* what) const {
    EXPECT_NEAR(sum / count, degrees, 4 * std::sqrt(2.0 * degrees / count)) << what;
  }
};

// The errors of vertices of each source, alone and together, are as large and as alike as their covariance says: marks
// and poses have errors, and the surface moves with the poses.
TEST(PlottedVertex, CovariancesAreThoseOfTheErrorsAloneAndTogether) {
  MeanSquare stereo, mono, on_surface, together, distance, cloud;
  const TestFolder folder;
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    const MarkingScene scene = marking_scene(seed);
    Random random(seed, 21);
    const ControlId a{0}, b{1}, c{2}, d{3};
    const auto at_b = seen_by_block(scene, b), at_c = seen_by_block(scene, c), at_d = seen_by_block(scene, d);
    const auto marks_a = marks_of(scene, a, 3, random), marks_b = marks_of(scene, b, 1, random),
               marks_d = marks_of(scene, d, 2, random);
    if (!at_b || !at_c || !at_d || marks_a.size() < 3 || marks_b.empty() || marks_d.size() < 2) continue;
    const Plane plane(*at_b + kRelative_m * random.normal() * Vector3d::UnitZ(),
                      *at_c + kRelative_m * random.normal() * Vector3d::UnitZ());
    auto surface = surface_of(folder, plane);
    ASSERT_TRUE(surface) << surface.error().message;
    VertexPlotter plotter(scene.marking(), nullptr, &*surface);
    const double east = random.normal(), north = random.normal();
    const Vector2d click = at_c->head<2>() + kClick_m * Vector2d(east, north);
    const Vector3d of_cloud = *at_d + 0.02 * testing::normal3(random);
    const AskedVertex asked[] = {MarkedVertex{marks_a}, MarkedVertex{marks_b}, VertexOnSurface{click, kClick_m},
                                 MarkedVertex{marks_d},
                                 GivenVertex{of_cloud, Vector3d::Constant(0.02), VertexSource::kCloud}};
    const ControlId truth[] = {a, b, c, d, d};
    std::vector<PlottedVertex> vertices;
    VectorXd errors(15);
    for (int i = 0; i < 5; ++i) {
      auto vertex = plotter.plot(asked[i]);
      if (!vertex) break;  // too parallel
      errors.segment<3>(3 * i) = vertex->position_in_world - scene.points.at(truth[i]);
      vertices.push_back(*std::move(vertex));
    }
    if (vertices.size() < 5) continue;
    const auto covariance = plotter.covariance(vertices);
    ASSERT_TRUE(covariance) << covariance.error().message;
    const auto part = [&](int i) { return std::pair(errors.segment<3>(3 * i), covariance->block<3, 3>(3 * i, 3 * i)); };
    const auto add = [&](MeanSquare& to, int i) { to.add(part(i).first, part(i).second); };
    add(stereo, 0);
    add(mono, 1);
    add(on_surface, 2);
    add(cloud, 4);
    together.add(errors, *covariance);
    const VertexFigures figures(plotter, {vertices[0], vertices[3]});
    const auto measured = figures.measure(FigureKind::kDistance);
    ASSERT_TRUE(measured);
    const double is = (scene.points.at(a) - scene.points.at(d)).norm();
    distance.add(VectorXd::Constant(1, measured->value - is),
                 Eigen::MatrixXd::Constant(1, 1, std::pow(*measured->sigma, 2)));
  }
  ASSERT_GT(stereo.count, 80);
  stereo.expect(3, "stereo");
  mono.expect(3, "mono");
  on_surface.expect(3, "surface");
  cloud.expect(3, "cloud");
  together.expect(15, "together");
  distance.expect(1, "distance");
}

// A click on the ground beside a house may have meant its roof: both lie within two standard deviations. Far from the
// wall there is no such doubt, and a slope of 45 degrees is none either.
TEST(PlottedVertex, BesideAWallTheOtherSideIsWithinTwoStandardDeviations) {
  const MarkingScene scene = marking_scene(1, false);
  const TestFolder folder;
  const MapGrid grid{-60, 60, kCell_m, 240, 240, ""};
  const auto height = [](double x, double y) { return x < 0 ? 0 : x < 20 ? 5 : 5 + (x - 20) + 0 * y; };
  ASSERT_TRUE(write_raster(folder / "dsm.tif", grid, height));
  for (const char* name : {"dsm_sigma.tif", "dsm_sigma_relative.tif"})
    ASSERT_TRUE(write_raster(folder / name, grid, [](double, double) { return kRelative_m; }));
  auto surface = PlottingSurface::open(folder / "dsm.tif");
  ASSERT_TRUE(surface);
  VertexPlotter plotter(scene.marking(), nullptr, &*surface);
  const auto sigma_h = [&](double x) {
    const auto vertex = plotter.plot(VertexOnSurface{{x, 5}, 0.01});
    EXPECT_TRUE(vertex && vertex->errors) << x;
    return vertex && vertex->errors ? std::sqrt(vertex->errors->covariance_m2(2, 2)) : 0;
  };
  for (const double x : {-1.0, 1.0}) EXPECT_GT(2 * sigma_h(x), 5) << x;
  for (const double x : {-4.0, 10.0}) EXPECT_NEAR(sigma_h(x), kRelative_m, 1e-3) << x;
  EXPECT_LT(sigma_h(25), 2 * kRelative_m);
}

}  // namespace
}  // namespace collinea
