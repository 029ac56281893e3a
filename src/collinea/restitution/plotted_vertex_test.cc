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
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
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
    const MarkingBlock marking = scene.marking_together();
    VertexPlotter plotter(marking, nullptr, &*surface);
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
  ASSERT_GT(stereo.count, 200);
  stereo.expect(3, "stereo");
  mono.expect(3, "mono");
  on_surface.expect(3, "surface");
  cloud.expect(3, "cloud");
  together.expect(15, "together");
  distance.expect(1, "distance");
}

// A vertex is to the block what one more tie point would be: the adjustment of everything together, with a camera that
// is free, gives it the same covariance. Marks are where the block shows the point, so that nothing moves.
TEST(PlottedVertex, AVertexIsATiePointOfTheBlock) {
  for (const Calibration calibration : {Calibration::kNone, Calibration::kFocalRadial}) {
    const MarkingScene scene = marking_scene(3, true, 0.05, calibration);
    const Vector3d at = scene.points.at(ControlId{1});
    Block with_point = scene.block;
    const PointId id{1'000'000};
    with_point.points[id].position_in_world = at;
    std::vector<ImageMark> marks;
    for (const OrientedImage& one : oriented_images(scene.block)) {
      const Camera& camera = scene.block.camera_of(one.image);
      const auto pixel = project(camera, one.cam_from_world * at);
      if (!pixel || !inside(camera, *pixel) || marks.size() == 4) continue;
      marks.push_back({one.image, *pixel, 0.3 + 0.1 * double(marks.size())});
      with_point.observations.push_back({one.image, id, 0, *pixel, marks.back().sigma_px});
    }
    ASSERT_EQ(marks.size(), 4u);
    ExamineOptions options{.adjust = testing::plain(calibration)};
    options.point_covariances = true;
    const auto together = examine(with_point, scene.scope, options, {});
    ASSERT_TRUE(together);
    ASSERT_EQ(together->points.back().first, id);
    EXPECT_LT((together->points.back().second - at).norm(), 1e-6);
    const Eigen::Matrix3d expected = together->point_covariance.back();
    const MarkingBlock marking = scene.marking_together();
    VertexPlotter plotter(marking, nullptr, nullptr);
    const auto vertex = plotter.plot(MarkedVertex{marks});
    ASSERT_TRUE(vertex) << vertex.error().message;
    EXPECT_LT((vertex->position - at).norm(), 1e-6);
    const auto covariance = plotter.covariance_in_map(*vertex);
    ASSERT_TRUE(covariance);
    EXPECT_LT((*covariance - expected).norm(), 1e-6 * expected.norm()) << *covariance << "\n\n" << expected;
  }
}

// With errors the estimate is that of the adjustment of everything together as well: what is left is of second order.
TEST(PlottedVertex, TheEstimateIsThatOfTheWholeBlock) {
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const MarkingScene scene = marking_scene(seed, true, 0.05, Calibration::kFocalRadial);
    Random random(seed, 5);
    const auto marks = marks_of(scene, ControlId{0}, 4, random);
    if (marks.size() < 4) continue;
    const MarkingBlock marking = scene.marking_together();
    VertexPlotter plotter(marking, nullptr, nullptr);
    const auto vertex = plotter.plot(MarkedVertex{marks});
    if (!vertex) continue;
    Block with_point = scene.block;
    const PointId id{1'000'000};
    with_point.points[id].position_in_world = vertex->position;
    std::map<ImageId, ImageMark> by_image;
    for (const ImageMark& mark : marks) by_image[mark.image] = mark;
    for (const auto& [image, mark] : by_image)
      with_point.observations.push_back({image, id, 0, mark.pixel, mark.sigma_px});
    ExamineOptions options{.adjust = testing::plain(Calibration::kFocalRadial)};
    const auto together = examine(with_point, scene.scope, options, {});
    ASSERT_TRUE(together);
    const auto covariance = plotter.covariance_in_map(*vertex);
    ASSERT_TRUE(covariance);
    const Vector3d difference = together->points.back().second - vertex->position;
    EXPECT_LT(difference.dot(covariance->ldlt().solve(difference)), std::pow(3e-3, 2)) << seed;
    ++count;
  }
  EXPECT_GT(count, 5);
}

// What an error of a camera does to vertices of one mark and on the surface is what a camera that is another makes of
// them, the surface being moved as its images see it.
TEST(PlottedVertex, CamerasMoveVerticesAsTheirErrorsSay) {
  const TestFolder folder;
  const MarkingScene scene = marking_scene(3, false, 0.05, Calibration::kFocalRadial);
  const Vector3d at = scene.points.at(ControlId{1});
  const Plane plane(at, scene.points.at(ControlId{2}));
  auto surface = surface_of(folder, plane);
  ASSERT_TRUE(surface) << surface.error().message;
  const MarkingBlock marking = scene.marking();
  VertexPlotter plotter(marking, nullptr, &*surface);
  const auto pixel_of = [&](ImageId image) {
    return *project(scene.block.camera_of(image), pose_of(scene.block, image) * at);
  };
  const auto on_surface = plotter.plot(VertexOnSurface{at.head<2>(), 0.1});
  ASSERT_TRUE(on_surface && on_surface->errors);
  std::vector<ImageMark> of_surface;  // the images that made it, with equal weights
  for (const auto& [image, moved] : on_surface->errors->by_images.by_pose)
    of_surface.push_back({image, pixel_of(image), 1});
  ASSERT_EQ(of_surface.size(), VertexPlotter::kNearest);
  const ImageMark one = of_surface.back();
  const auto mono = plotter.plot(MarkedVertex{{one}});
  ASSERT_TRUE(mono && mono->errors) << mono.error().message;
  const auto exact_stereo = [&](const Block& block) {
    const PoseCovariances exact;
    const MarkingBlock in{block, scene.observations, exact};
    return VertexPlotter(in, nullptr, nullptr).plot(MarkedVertex{of_surface})->position;
  };
  const MarkingBlock together = scene.marking_together();
  const auto joint = together.poses_together(std::vector{one.image});
  ASSERT_TRUE(joint && joint->cameras.size() == 1);
  const std::vector<int> params = joint->cameras[0].params;
  ASSERT_GE(params.size(), 2u);
  for (const int param : params) {
    const Vector3d by_surface = on_surface->errors->by_images.by_camera.at(0).second.col(param),
                   by_mono = mono->errors->by_images.by_camera.at(0).second.col(param);
    const double step = 0.02 / by_surface.norm();  // 2 cm
    Block moved = scene.block, moved_back = scene.block;
    moved.cameras.at(joint->cameras[0].camera).params[std::size_t(param)] += step;
    moved_back.cameras.at(joint->cameras[0].camera).params[std::size_t(param)] -= step;
    const Vector3d surface_moves = exact_stereo(moved) - exact_stereo(scene.block);
    EXPECT_LT((exact_stereo(moved) - exact_stereo(moved_back) - 2 * step * by_surface).norm(), 1e-3 * 0.04) << param;
    Plane plane_now = plane;
    plane_now.at += surface_moves;
    auto surface_now = surface_of(folder, plane_now);
    ASSERT_TRUE(surface_now);
    const MarkingBlock marking_now{moved, scene.observations, scene.poses};
    const auto mono_now = VertexPlotter(marking_now, nullptr, &*surface_now).plot(MarkedVertex{{one}});
    ASSERT_TRUE(mono_now) << mono_now.error().message;
    EXPECT_LT((mono_now->position - mono->position - step * by_mono).norm(), 0.01 * 0.02) << param;
    EXPECT_GT(step * by_mono.norm(), 0.002) << param;
  }
}

// Of more vertices or images than a covariance is computed of, figures have their value without a standard deviation.
TEST(PlottedVertex, LargeFiguresHaveTheirValue) {
  const MarkingScene scene = marking_scene(2, false);
  const MarkingBlock marking = scene.marking();
  VertexPlotter plotter(marking, nullptr, nullptr);
  const auto line_of = [&](std::size_t count) {
    std::vector<PlottedVertex> line;
    for (std::size_t i = 0; i < count; ++i)
      line.push_back(*plotter.plot(GivenVertex{{3.0 * double(i), 4.0 * double(i), 7}, Vector3d::Constant(0.1)}));
    return line;
  };
  constexpr std::size_t kMost = VertexPlotter::kMostVertices;
  const auto most = VertexFigures(plotter, line_of(kMost)).measure(FigureKind::kLength);
  ASSERT_TRUE(most && most->sigma);
  EXPECT_NEAR(*most->sigma, 0.1 * std::sqrt(2), 1e-9);  // of a straight line that of its ends
  const auto more = VertexFigures(plotter, line_of(2000)).measure(FigureKind::kLength);
  ASSERT_TRUE(more) << more.error().message;
  EXPECT_NEAR(more->value, 5.0 * 1999, 1e-6);
  EXPECT_FALSE(more->sigma);
  std::vector<PlottedVertex> of_many = line_of(2);
  for (std::uint32_t i = 0; i <= VertexPlotter::kMostImages; ++i)
    of_many[i % 2].errors->by_images.by_pose.emplace_back(ImageId{i}, MovedByImages::ByPose::Zero());
  const auto distance = VertexFigures(plotter, of_many).measure(FigureKind::kDistance);
  ASSERT_TRUE(distance) << distance.error().message;
  EXPECT_NEAR(distance->value, 5, 1e-9);
  EXPECT_FALSE(distance->sigma);
  EXPECT_FALSE(VertexFigures(plotter, line_of(3)).measure(FigureKind::kDistance));  // of two points only
}

// What has no position is refused with the reason, and never given one: a single ray without a surface, two marks in
// one image, rays that are parallel or meet behind the cameras, a point at infinity, marks that are none.
TEST(PlottedVertex, DegenerateMarksAreRefused) {
  for (const bool together : {false, true}) {
    const MarkingScene scene = marking_scene(2, false);
    const MarkingBlock marking = together ? scene.marking_together() : scene.marking();
    VertexPlotter plotter(marking, nullptr, nullptr);
    const auto refused = [&](std::vector<ImageMark> marks, std::string_view part) {
      const auto vertex = plotter.plot(MarkedVertex{std::move(marks)});
      ASSERT_FALSE(vertex) << part << ": " << vertex->position.transpose();
      EXPECT_NE(vertex.error().message.find(part), std::string::npos) << vertex.error().message;
    };
    const auto images = oriented_images(scene.block);
    const Rigid3 first = images[0].cam_from_world, second = images[1].cam_from_world;
    const auto pixel_along = [&](const OrientedImage& image, const Vector3d& direction) {
      return project(scene.block.camera_of(image.image), image.cam_from_world.rotation * direction);
    };
    refused({}, "one mark or more");
    refused({{images[0].image, {700, 500}}}, "no surface that the ray could meet");
    refused({{images[0].image, {700, 500}}, {images[0].image, {710, 500}}}, "all marks are of one image");
    refused({{images[0].image, {700, 500}}, {ImageId{9999}, {710, 500}}}, "no such image");
    refused({{images[0].image, {700, 500}, 0}, {images[1].image, {710, 500}}}, "above 0");
    refused({{images[0].image, {700, -1}}, {images[1].image, {710, 500}}}, "not inside");
    refused({{images[0].image, {700, std::nan("")}}, {images[1].image, {710, 500}}}, "not inside");
    // One direction of the world in both images: parallel rays, a point at infinity.
    Vector3d down(0, 0, -1);
    int parallel = 0;
    for (const Vector3d& aside : {Vector3d(0, 0, 0), Vector3d(0.05, 0.1, 0), Vector3d(-0.1, 0.05, 0)}) {
      const Vector3d direction = (down + aside).normalized();
      const auto one = pixel_along(images[0], direction), other = pixel_along(images[1], direction);
      if (!one || !other || !inside(scene.block.camera_of(images[0].image), *one) ||
          !inside(scene.block.camera_of(images[1].image), *other))
        continue;
      refused({{images[0].image, *one}, {images[1].image, *other}}, "do not meet");
      ++parallel;
    }
    EXPECT_GT(parallel, 0);
    // Rays that spread: they meet above the cameras, behind them.
    const Vector3d base = (centre_of(second) - centre_of(first)).normalized();
    const auto one = pixel_along(images[0], down - 0.1 * base), other = pixel_along(images[1], down + 0.1 * base);
    ASSERT_TRUE(one && other);
    refused({{images[0].image, *one}, {images[1].image, *other}}, "behind a camera");
  }
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
