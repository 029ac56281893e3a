// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/pair.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/cloud/ply.h"
#include "collinea/epipolar/epipolar_lines.h"
#include "collinea/geometry/rotation.h"
#include "collinea/jobs/correlate.h"
#include "collinea/jobs/evaluate.h"
#include "collinea/jobs/grid_points.h"
#include "collinea/jobs/internal/pair_orientation.h"
#include "collinea/jobs/internal/village_pair_for_tests.h"
#include "collinea/jobs/intersection.h"
#include "collinea/math/median.h"
#include "collinea/math/random.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/synthetic/film.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

using testing::kVillageFocal_px;
using testing::VillagePair;

// Every point with its test, and none that was kept beyond the limit; parallaxes are those of the orientation.
void expect_points_with_tests(const PairReport& report, const std::filesystem::path& folder) {
  const auto points = read_text_table(folder / "points.txt");
  ASSERT_TRUE(points);
  const PairOrientation& last = report.orientations.back();
  ASSERT_EQ(points->rows.size(), last.points);
  const auto parallax = *points->numbers("y_parallax", "px"), test = *points->numbers("test", "1"),
             sigma = *points->numbers("sigma", "px");
  const auto used = *points->words("used");
  double squares = 0;
  std::size_t rejected = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    EXPECT_GT(sigma[i], 0);
    if (used[i] == "no") {
      ++rejected;  // its test is that of the end: points that were rejected after it have changed it
      continue;
    }
    EXPECT_LE(std::abs(test[i]), last.orientation.limit + 0.01);
    squares += parallax[i] * parallax[i];
  }
  EXPECT_EQ(rejected, last.rejected);
  // Of epipolar images the same parallax is a difference of rows.
  EXPECT_NEAR(std::sqrt(squares / double(last.orientation.used)), report.y_parallax_rms_px,
              0.1 * report.y_parallax_rms_px);
  const auto all = read_text_table(folder / "rejected.txt");
  ASSERT_TRUE(all);
  std::size_t sum = 0;
  for (const PairOrientation& of : report.orientations) sum += of.rejected;
  EXPECT_EQ(all->rows.size(), sum);
}

// The control by the exterior orientations that the pair wrote: its measurements and coordinates are exact.
void expect_intersection_goes_on(const VillagePair& village) {
  const auto control = read_text_table(village.folder / "control.txt");
  ASSERT_TRUE(control);
  std::string marks = "image point x[px] y[px] sigma[px]\n";
  for (const auto& row : control->rows) {
    marks += fmt::format("{} {} {} {} 0.01\n", village.left.filename().string(), row[0], row[7], row[8]);
    marks += fmt::format("{} {} {} {} 0.01\n", village.right.filename().string(), row[0], row[9], row[10]);
  }
  ASSERT_TRUE(write_file(village.folder / "marks.txt", marks));
  IntersectTableOptions options;
  options.photo.principal_distance = kVillageFocal_px;
  options.photo.principal_point = "400,300";
  options.ground = village.folder / "control.txt";
  const auto found =
      intersect_from_tables(village.folder / "marks.txt", village.folder / "pair/exterior.txt", options, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->orientations_have_sigmas);
  ASSERT_EQ(found->points.size(), control->rows.size());
  for (const auto& point : found->points) {
    ASSERT_TRUE(point.is_found && point.has_ground) << point.name;
    for (int axis = 0; axis < 3; ++axis) EXPECT_LT(std::abs(point.off_ground[axis]), 4 * point.sigma[axis]);
  }
}

// correlate goes along the lines that the pair wrote, from the points that it wrote.
void expect_epipolar_lines_lead_on(const VillagePair& village) {
  CorrelateOptions options;
  options.points = village.folder / "pair/points.txt";
  options.refine = WindowModel::kLine;
  options.epipolar = village.folder / "pair/fundamental.txt";
  options.matching.search_px = 41;
  const auto report = correlate_points(village.left, village.right, village.folder / "along", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  std::vector<double> off_line, off_truth;
  const Camera& camera = village.truth.cameras.begin()->second;
  const auto exact = fundamental_matrix(camera, camera, village.right_from_left());
  ASSERT_TRUE(exact);
  for (const CorrelatedPoint& point : report->points) {
    if (!point.is_refined()) continue;
    off_line.push_back(std::abs(*point.off_line_px));
    const Eigen::Vector3d line = *exact * point.left_px.homogeneous();
    off_truth.push_back(std::abs(line.dot(point.refined->position_px.homogeneous())) / line.head<2>().norm());
  }
  ASSERT_GT(off_line.size(), report->points.size() / 2);
  EXPECT_LT(median(off_line), 0.2);    // of area matching
  EXPECT_LT(median(off_truth), 0.05);  // of the lines: the orientation's errors alone
}

TEST(Pair, TwoImagesOfAVillageBecomeItsSurface) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.levels.levels = 4;
  options.levels.last_threshold = 300;
  options.levels.grid_px = 4;
  ASSERT_TRUE(write_file(village.folder / "control.txt", village.control_table()));
  options.control = village.folder / "control.txt";
  const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;

  const RelativeOrientation& found = report->orientations.back().orientation;
  const Rigid3 truth = village.right_from_left();
  const Eigen::Vector3d base = base_in_first(found.second_from_first);
  Vector5 change;
  change << rotation_vector(truth.rotation * found.second_from_first.rotation.conjugate()),
      tangents_of(base).transpose() * (base_in_first(truth) - base);
  const double chi2 = change.dot(found.stated_covariance().ldlt().solve(change));
  EXPECT_LT(chi2, 20.5);  // five degrees of freedom, one in a thousand
  EXPECT_LT(angle_between(found.second_from_first.rotation, truth.rotation), 3e-4);
  EXPECT_LT((found.second_from_first.translation - truth.translation.normalized()).norm(), 1e-3);
  EXPECT_LT(report->orientations.back().sigma0_px, 0.1);
  EXPECT_LT(report->y_parallax_rms_px, 0.15);

  // The model on the ground: its unit is the base.
  ASSERT_TRUE(report->absolute);
  EXPECT_NEAR(report->absolute->ground_from_model.scale, truth.translation.norm(), 0.002 * truth.translation.norm());
  EXPECT_GT(report->surface_points, 10'000u);
  for (const char* file :
       {"pair.txt", "points.txt", "epipolar_left.png", "epipolar_right.png", "epipolar_check.png", "rejected.txt",
        "relative_parameters.txt", "relative_correlations.txt", "relative_residuals.txt", "relative_geometry.svg",
        "model.txt", "exterior.txt", "absolute_parameters.txt", "absolute_correlations.txt", "absolute_residuals.txt"})
    EXPECT_TRUE(is_there(village.folder / "pair" / file)) << file;
  expect_points_with_tests(*report, village.folder / "pair");
  expect_intersection_goes_on(village);
  expect_epipolar_lines_lead_on(village);
}

TEST(Pair, TheDenseSurfaceHasMorePointsOnTheSameOrientation) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.surface = PairSurface::kDense;
  options.base_m = village.right_from_left().translation.norm();
  const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_GT(report->surface_points, 100'000u);
  // Depths about the flying height: the village reaches some way up to the camera.
  const auto cloud = read_ply(village.folder / "pair/cloud.ply");
  ASSERT_TRUE(cloud);
  std::size_t near = 0;
  for (const CloudPoint& point : *cloud) near += point.position.z() > 40 && point.position.z() < 70;
  EXPECT_GT(double(near) / double(cloud->size()), 0.99);
}

// Points found on images of half the size and measured on the whole ones orient them as well as those do.
TEST(Pair, OrientationOfLargeImagesBeginsOnSmallOnes) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  const auto pair = open_pair(village.left, village.right, village.folder / "pair", options, {});
  ASSERT_TRUE(pair) << pair.error().message;
  PairReport report;
  const auto oriented = orient_pair(*pair, {.search = 2, .surface = 1}, options, report, {.threads = 2});
  ASSERT_TRUE(oriented) << oriented.error().message;
  EXPECT_EQ(oriented->images.left.width, 800);
  ASSERT_EQ(report.orientations.size(), 3u);
  EXPECT_EQ(report.orientations[1].shrink, 2);
  EXPECT_EQ(report.orientations[2].shrink, 1);
  EXPECT_EQ(report.search.back().shrink, 2);
  const RelativeOrientation& found = report.orientations.back().orientation;
  const Rigid3 truth = village.right_from_left();
  const Eigen::Vector3d base = base_in_first(found.second_from_first);
  Vector5 change;
  change << rotation_vector(truth.rotation * found.second_from_first.rotation.conjugate()),
      tangents_of(base).transpose() * (base_in_first(truth) - base);
  EXPECT_LT(change.dot(found.stated_covariance().ldlt().solve(change)), 20.5);  // one in a thousand of five degrees
  // Pixels of the small images are twice as large: measured on them alone the sigma would be about twice this.
  EXPECT_LT(report.orientations[2].sigma0_px, 0.1);
  const auto model = model_of(*oriented, found, 1);
  ASSERT_TRUE(model);
  EXPECT_EQ(model->points.size(), oriented->points.size());
}

TEST(Pair, SameBitsForAnyNumberOfThreads) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.levels.levels = 3;
  options.base_m = 17;
  for (const PairSurface surface : {PairSurface::kLevels, PairSurface::kDense}) {
    options.surface = surface;
    if (surface == PairSurface::kDense) options.levels = {};
    const auto one = village.folder / "one", three = village.folder / "three";
    ASSERT_TRUE(orient_and_match(village.left, village.right, one, options, {.threads = 1}));
    ASSERT_TRUE(orient_and_match(village.left, village.right, three, options, {.threads = 3}));
    for (const char* file : {"cloud.ply", "pair.txt", "points.txt", "epipolar_left.png", "dsm.tif", "ortho.tif"})
      EXPECT_EQ(*read_file(one / file), *read_file(three / file)) << file;
  }
}

// The lens of a camera file: without it, rays of the corners miss one another.
TEST(Pair, ALensComesFromACameraFile) {
  const VillagePair village({.k1 = -0.06});
  PairChainOptions options;
  options.camera = village.folder / "camera.txt";
  options.levels.levels = 1;
  ASSERT_TRUE(
      write_file(*options.camera, "# ID MODEL WIDTH HEIGHT PARAMS\n1 OPENCV 800 600 600 600 400 300 -0.06 0 0 0\n"));
  const auto with = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(with) << with.error().message;
  const Rigid3 truth = village.right_from_left();
  const RelativeOrientation& found = with->orientations.back().orientation;
  EXPECT_LT(angle_between(found.second_from_first.rotation, truth.rotation), 5e-4);
  EXPECT_LT(with->orientations.back().sigma0_px, 0.1);
  EXPECT_FALSE(is_there(village.folder / "pair/fundamental.txt"));  // its epipolar lines are curves
  options.camera.reset();
  options.principal_distance_px = kVillageFocal_px;
  const auto without = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(without) << without.error().message;
  const auto angle = [&](const PairReport& report) {
    return angle_between(report.orientations.back().orientation.second_from_first.rotation, truth.rotation);
  };
  EXPECT_GT(angle(*without), 4 * angle(*with));
  options.camera = village.folder / "camera.txt";
  const auto both = orient_and_match(village.left, village.right, village.folder / "pair", options, {});
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().options.front().name, "camera");
}

TEST(Pair, EpipolarImagesAreResampledAsAsked) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.levels.levels = 1;
  const auto cubic = village.folder / "cubic", linear = village.folder / "linear";
  ASSERT_TRUE(orient_and_match(village.left, village.right, cubic, options, {.threads = 2}));
  options.resampling = Interpolation::kBilinear;
  ASSERT_TRUE(orient_and_match(village.left, village.right, linear, options, {.threads = 2}));
  const auto a = read_grey(cubic / "epipolar_left.png"), b = read_grey(linear / "epipolar_left.png");
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->data.size(), b->data.size());
  // The mean of four samples has less of the grey values' differences than cubic convolution.
  const auto roughness = [](const GreyImage& image) {
    double squares = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 1; x < image.width; ++x)
        if (image.at(x, y) && image.at(x - 1, y)) squares += std::pow(image.at(x, y) - image.at(x - 1, y), 2);
    return squares;
  };
  EXPECT_LT(roughness(*b), 0.9 * roughness(*a));
  EXPECT_GT(roughness(*b), 0.3 * roughness(*a));
}

TEST(Pair, NothingIsLeftBehindAfterAnError) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.levels.levels = 3;
  options.base_m = 17;
  const auto folder = village.folder / "pair";
  std::filesystem::create_directories(folder / "ortho.tif/in_the_way");
  EXPECT_FALSE(orient_and_match(village.left, village.right, folder, options, {.threads = 2}));
  EXPECT_TRUE(is_there(folder / "dsm.tif"));
  EXPECT_FALSE(is_there(folder / "scratch"));
}

// Heights of the map at its middle part beside those of the truth.
TEST(Pair, ControlMakesItAMap) {
  const VillagePair village;
  PairChainOptions options;
  options.principal_distance_px = kVillageFocal_px;
  options.surface = PairSurface::kDense;
  ASSERT_TRUE(write_file(village.folder / "control.txt", village.control_table()));
  options.control = village.folder / "control.txt";
  options.cell_m = 0.2;
  const auto report = orient_and_match(village.left, village.right, village.folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(report->map);
  EXPECT_EQ(report->map->cell_m, 0.2);
  EXPECT_GT(report->map->painted_cells, 20'000u);
  const auto dsm = GeoTiffReader::open(village.folder / "pair/dsm.tif");
  const auto ortho = GeoTiffReader::open(village.folder / "pair/ortho.tif");
  ASSERT_TRUE(dsm && ortho);
  EXPECT_EQ(ortho->channels(), 4);
  std::vector<double> errors = village.height_errors(village.folder / "pair/dsm.tif");
  ASSERT_GT(errors.size(), 5000u);
  EXPECT_NEAR(median(errors), 0, 0.01);  // of thousands of cells
  for (double& error : errors) error = std::abs(error);
  EXPECT_LT(median(errors), 0.04);  // pixels of 0.1 m, a fifth of one in the disparity, base over height 1/2
  for (const char* file : {"dsm_sigma.tif", "dsm_state.tif", "dsm_hillshade.tif", "ortho_source.tif"})
    EXPECT_TRUE(is_there(village.folder / "pair" / file)) << file;
}

TEST(Pair, ScansOfFilmBecomeAMap) {
  const TestFolder folder;
  SurveyOptions flight;
  flight.strips = 1;
  flight.images_per_strip = 2;
  flight.control_points = 6;
  flight.check_points = 0;
  flight.measurement_sigma_px = 0;
  FilmOptions film;
  film.scan_um = 120;
  ASSERT_TRUE(simulate(flight, film, folder / "block", {.threads = 2}));
  const FilmTruth truth = *make_film_survey(flight, film, {});
  std::string table =
      "point X[m] Y[m] Z[m] sigma_X[m] sigma_Y[m] sigma_Z[m] x_left[px] y_left[px] x_right[px] y_right[px]\n";
  for (const auto& [id, mark] : truth.truth.marks_in_world) {
    Eigen::Vector2d at[2];
    for (const ControlObservation& seen : truth.truth.block.control_observations)
      if (seen.point == id) at[seen.image.value] = scan_pixel_of(truth, seen.image, seen.pixel);
    table += fmt::format("C{} {} {} {} 0.01 0.01 0.01 {} {} {} {}\n", id.value, mark.x(), mark.y(), mark.z(), at[0].x(),
                         at[0].y(), at[1].x(), at[1].y());
  }
  ASSERT_TRUE(write_file(folder / "control.txt", table));
  PairChainOptions options;
  options.film.calibration = folder / "block/film_calibration.txt";
  options.control = folder / "control.txt";
  options.surface = PairSurface::kDense;
  const auto left = folder / "block/images/IMG_0001.jpg", right = folder / "block/images/IMG_0002.jpg";
  const auto report = orient_and_match(left, right, folder / "pair", options, {.threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->scans.size(), 2u);
  EXPECT_EQ(report->scans[0].marks, 8u);
  EXPECT_LT(report->scans[1].rms_um, 10);  // deformation of 4 um, readings of 0.05 px
  ASSERT_TRUE(report->absolute && report->map);
  EXPECT_LT(report->absolute->sigma0, 0.5);  // control is exact, stated as 0.5 px
  // A pixel is 0.96 m on the ground.
  const Similarity3& ground_from_model = report->absolute->ground_from_model;
  const Eigen::Vector3d centre = centre_of(pose_of(truth.truth.block, ImageId{0}));
  EXPECT_LT((ground_from_model.translation - centre).norm(), 1);
  PairChainOptions no_film;
  no_film.principal_distance_px = 1000;
  no_film.film.marks.turned_deg = 90;
  EXPECT_EQ(orient_and_match(left, right, folder / "pair", no_film, {}).error().options.front().name, "film");
  options.cell_m = 0.2;  // a fifth of a pixel on the ground
  const auto fine = orient_and_match(left, right, folder / "pair", options, {.threads = 2});
  ASSERT_FALSE(fine);
  EXPECT_EQ(fine.error().options.front().name, "cell_m");
  options.principal_distance_px = 1000;
  EXPECT_FALSE(orient_and_match(left, right, folder / "pair", options, {}));
}

TEST(Pair, SaysWhatIsMissingOrWrong) {
  const VillagePair village;
  PairChainOptions options;
  const auto nothing = orient_and_match(village.left, village.right, village.folder / "pair", options, {});
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().message.find("principal distance"), std::string::npos);
  options.principal_distance_px = kVillageFocal_px;
  EXPECT_FALSE(orient_and_match(village.left, village.folder / "none.jpg", village.folder / "pair", options, {}));
  GreyImage noise(800, 600);
  Random random(4);
  for (auto& grey : noise.data) grey = std::uint8_t(1 + random.below(255));
  ASSERT_TRUE(write_png(village.folder / "noise.png", noise));
  const auto other = orient_and_match(village.left, village.folder / "noise.png", village.folder / "pair", options, {});
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("do not show the same"), std::string::npos);
  options.reject_control = true;
  const auto reject = orient_and_match(village.left, village.right, village.folder / "pair", options, {});
  ASSERT_FALSE(reject);
  EXPECT_EQ(reject.error().options.front().name, "reject_control");
  options.reject_control = false;
  ASSERT_TRUE(write_file(village.folder / "control.txt", "point X[m] Y[m]\nA 1 2\n"));
  options.control = village.folder / "control.txt";
  const auto columns = orient_and_match(village.left, village.right, village.folder / "pair", options, {});
  ASSERT_FALSE(columns);
  EXPECT_NE(columns.error().message.find("x_left"), std::string::npos);
  ASSERT_TRUE(write_file(village.folder / "control.txt",
                         "point X[m] Y[m] Z[m] x_left y_left x_right y_right role\nA 1 2 3 4 5 6 7 cheque\n"));
  const auto role = orient_and_match(village.left, village.right, village.folder / "pair", options, {});
  ASSERT_FALSE(role);
  EXPECT_NE(role.error().message.find("cheque"), std::string::npos);
}

// Points of a hillside to a raster, and that raster beside other points of it.
TEST(GridPoints, AndEvaluateFindTheSameHill) {
  const TestFolder folder;
  std::string some = "point X[m] Y[m] Z[m] sigma_Z[mm]\n", others = "X;Y;Z[cm]\n";
  for (int i = 0; i < 900; ++i) {
    const double x = 5e5 + (i * 37 % 101), y = 5e6 + (i * 53 % 97), z = 300 + 5 * std::sin(x / 20) + 0.1 * (y - 5e6);
    const std::string at = std::to_string(x) + (i % 3 ? " " : ";") + std::to_string(y) + (i % 3 ? " " : ";");
    if (i % 3)
      some += std::to_string(i) + " " + at + std::to_string(z) + " 1\n";
    else
      others += at + std::to_string(100 * (z + 0.25)) + "\n";
  }
  ASSERT_TRUE(write_file(folder / "some.txt", some));
  ASSERT_TRUE(write_file(folder / "others.txt", others));
  GridPointsOptions grid;
  grid.cell_m = 1;
  const auto gridded = grid_points(folder / "some.txt", folder / "hill.tif", grid, {});
  ASSERT_TRUE(gridded) << gridded.error().message;
  EXPECT_EQ(gridded->points, 600u);
  EXPECT_LT(gridded->left_out_rms_m, 0.1);
  EXPECT_TRUE(is_there(folder / "hill_sigma.tif"));
  EvaluateOptions options;
  options.coregistration = Coregistration::kNone;
  options.tolerance_m = 0.1;
  options.out = folder / "differences";
  const auto evaluation = evaluate_surface(folder / "hill.tif", folder / "others.txt", options, {});
  ASSERT_TRUE(evaluation) << evaluation.error().message;
  EXPECT_GT(evaluation->comparison.all.count(), 250u);
  EXPECT_NEAR(evaluation->comparison.all.median_m(), -0.25, 0.02);  // the others lie higher
  EXPECT_TRUE(is_there(folder / "differences/differences.png"));
  EXPECT_TRUE(is_there(folder / "differences/evaluation.txt"));
  // Points come at x from 5e5 to 5e5 + 100: the western half of the area holds about half of them.
  options.area = "500000,4999000,500050,5001000";
  const auto part = evaluate_surface(folder / "hill.tif", folder / "others.txt", options, {});
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_GT(part->comparison.all.count(), 0.4 * evaluation->comparison.all.count());
  EXPECT_LT(part->comparison.all.count(), 0.6 * evaluation->comparison.all.count());
  for (const char* wrong : {"1,2,3", "2,1,1,2", "a,b,c,d"}) {
    options.area = wrong;
    EXPECT_EQ(evaluate_surface(folder / "hill.tif", folder / "others.txt", options, {}).error().options.front().name,
              "area");
  }
}

TEST(GridPoints, AndEvaluateRefuseOptionsThatWouldNotBeRead) {
  const TestFolder folder;
  GridPointsOptions grid;
  grid.method = GridMethod::kPlanes;
  grid.spacing_m = 3;
  EXPECT_EQ(grid_points(folder / "none.txt", folder / "x.tif", grid, {}).error().options.front().name, "spacing_m");
  ASSERT_TRUE(write_file(folder / "two.txt", "X[m] Y[m] Z[m]\n1 2 3\n4 5 6\n"));
  EXPECT_FALSE(grid_points(folder / "two.txt", folder / "x.tif", {}, {}));
}

}  // namespace
}  // namespace collinea
