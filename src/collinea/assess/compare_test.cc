// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "collinea/assess/assess.h"
#include "collinea/base/test_folder.h"
#include "collinea/cloud/las.h"
#include "collinea/math/random.h"
#include "collinea/surface/surface_filter.h"

namespace collinea {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// A block of six cameras over two marks, and its true poses.
struct Survey {
  Block block;
  std::map<std::string, Rigid3> truth;
  std::map<std::string, Eigen::Vector3d> marks{{"A", {3, 4, 1}}, {"B", {-5, 2, 0}}};

  Survey() {
    block.cameras[CameraId{1}] = ideal_camera(1000, 1200, 1000);
    block.cameras[CameraId{1}].params[Camera::kK1] = -0.05;
    for (std::uint32_t i = 0; i < 6; ++i) {
      const Eigen::Quaterniond rotation(Eigen::AngleAxisd(3.1, Eigen::Vector3d(1, 0.02 * i, 0.01).normalized()));
      const Eigen::Vector3d centre(10.0 * (i % 3) - 10, 10.0 * (i / 3) - 5, 40 + i);
      const std::string file = "IMG_" + std::to_string(i) + ".jpg";
      block.images[ImageId{i}].file = "sub/" + file;
      block.images[ImageId{i}].camera = CameraId{1};
      truth[file] = {rotation, -(rotation * centre)};
      set_pose(block, ImageId{i}, truth[file]);
    }
    std::uint32_t id = 0;
    for (const auto& [name, position] : marks) {
      ControlPoint point;
      point.name = name;
      point.role = name == "A" ? ControlRole::kCheck : ControlRole::kControl;
      block.control[ControlId{id}] = point;
      for (const auto& [image, pose] : oriented_images(block))
        if (const auto pixel = project(block.camera_of(image), pose * position))
          block.control_observations.push_back({ControlId{id}, image, *pixel, 0.5});
      ++id;
    }
  }
};

Eigen::Vector3d same(const Eigen::Vector3d& p) { return p; }

TEST(PoseErrors, PerfectPosesHaveNone) {
  const Survey survey;
  const PoseErrors errors = pose_errors(survey.block, survey.truth, same);
  EXPECT_EQ(errors.images, 6u);
  EXPECT_EQ(errors.oriented, 6u);
  EXPECT_LT(errors.centres->rms_3d_m, 1e-12);
  EXPECT_LT(errors.after_similarity->rms_3d_m, 1e-10);
  EXPECT_LT(errors.rotation_rms_deg, 1e-6);
}

TEST(PoseErrors, ASimilarityShowsBeforeAndNotAfterAlignment) {
  Survey survey;
  const Similarity3 moved_by{1.01, Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ())), {2, 0, 0}};
  for (auto [id, pose] : oriented_images(survey.block)) {
    pose = moved(pose, moved_by);
    set_pose(survey.block, id, pose);
  }
  const PoseErrors errors = pose_errors(survey.block, survey.truth, same);
  EXPECT_GT(errors.centres->rms_3d_m, 1);
  EXPECT_LT(errors.after_similarity->rms_3d_m, 1e-10);
  EXPECT_NEAR(*errors.scale, 1 / 1.01, 1e-12);
  EXPECT_LT(errors.rotation_rms_deg, 1e-6);
  EXPECT_FALSE(pose_errors(survey.block, survey.truth, nullptr).centres);
}

TEST(PoseErrors, RmsMeanAndWorstAreWhatTheyAreCalled) {
  const std::vector<Eigen::Vector3d> estimated = {{1, 0, 0}, {-1, 0, 2}}, truth(2, Eigen::Vector3d::Zero());
  const PointErrors errors = point_errors(estimated, truth);
  EXPECT_TRUE(errors.rms_m.isApprox(Eigen::Vector3d(1, 0, std::sqrt(2.0))));
  EXPECT_TRUE(errors.mean_m.isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_NEAR(errors.rms_3d_m, std::sqrt(3.0), 1e-14);
  EXPECT_NEAR(errors.worst_3d_m, std::sqrt(5.0), 1e-14);
}

TEST(MarkErrors, AMarkIsIntersectedWhereItIs) {
  const Survey survey;
  EXPECT_LT((*intersect_mark(survey.block, ControlId{0}) - Eigen::Vector3d(3, 4, 1)).norm(), 1e-9);
  EXPECT_EQ(mark_errors(survey.block, ControlRole::kCheck, survey.marks, same).points, 1u);
  EXPECT_LT(mark_errors(survey.block, ControlRole::kControl, survey.marks, same).rms_3d_m, 1e-9);
}

TEST(MarkErrors, OneRayFixesNoMark) {
  Survey survey;
  survey.block.control_observations.resize(1);
  EXPECT_FALSE(intersect_mark(survey.block, ControlId{0}));
  EXPECT_EQ(mark_errors(survey.block, ControlRole::kCheck, survey.marks, same).points, 0u);
}

// A plain with a block of 5 m on it.
float height_at(double x, double y) { return x > 20 && x < 30 && y > 20 && y < 30 ? 5 : float(0.1 * x); }

HeightField field_of(double cell_m, int side, std::function<float(double, double)> height) {
  HeightField field;
  field.grid = {0, side * cell_m, cell_m, side, side, ""};
  field.read = [grid = field.grid, height](int column, int row, int width, int rows) -> Result<FloatImage> {
    FloatImage heights(width, rows);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < width; ++x)
        heights.at(x, y) = height(grid.east_of(column + x + 0.5), grid.north_of(row + y + 0.5));
    return heights;
  };
  return field;
}

TEST(SurfaceErrors, APerfectModelHasNoneEvenWithLargerCells) {
  const auto errors = surface_errors(field_of(0.2, 200, height_at), nullptr, field_of(0.1, 400, height_at), {}, nullptr,
                                     collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_LT(errors->smooth_ground.rmse_m, 1e-5);
  EXPECT_LT(errors->overall.rmse_m, 0.01);  // where steep the nearest true cell counts: half a cell of the slope
  EXPECT_NEAR(errors->completeness, 1, 1e-12);
}

TEST(SurfaceErrors, BiasNoiseHolesAndEdgesAreToldApart) {
  Random random(2);
  const auto model = [&](double x, double y) {
    if (x > 36) return kNone;
    const bool rim = std::abs(x - 20) < 0.2 && y > 20 && y < 30;
    return height_at(x, y) + 0.3f + (rim ? 4.0f : 0) + float(0.05 * random.normal());
  };
  const auto errors =
      surface_errors(field_of(0.1, 400, model), nullptr, field_of(0.1, 400, height_at), {}, nullptr, collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->smooth_ground.mean_m, 0.3, 0.001);  // 140,000 cells: sigma of the mean 0.00013
  EXPECT_NEAR(errors->smooth_ground.nmad_m, 0.05, 0.001);
  EXPECT_GT(errors->overall.rmse_m, errors->smooth_ground.rmse_m + 0.05);
  EXPECT_NEAR(errors->completeness, 0.9, 1e-3);
}

// The block of the plain, turned by 30 degrees and `wider` on every side.
float rotated_block(double x, double y, double wider) {
  const double u = (x - 20) * std::cos(0.5236) + (y - 20) * std::sin(0.5236);
  const double v = (y - 20) * std::cos(0.5236) - (x - 20) * std::sin(0.5236);
  return std::max(std::abs(u), std::abs(v)) < 6 + wider ? 5 : float(0.1 * x);
}

// Cells of 10 cm tell the point of a wall to 10 / sqrt(12) cm, one by one.
TEST(WallErrors, AreHowMuchTooWideABlockIs) {
  const HeightField truth = field_of(0.05, 800, [](double x, double y) { return rotated_block(x, y, 0); });
  for (const double wider : {-0.3, 0.0, 0.4}) {
    const HeightField model = field_of(0.1, 400, [=](double x, double y) { return rotated_block(x, y, wider); });
    const auto errors = wall_errors(model, truth, 0.1, collinea::Run{});
    ASSERT_TRUE(errors);
    EXPECT_GT(errors->samples, 250u);  // 48 m of walls, the corners left out
    EXPECT_NEAR(errors->mean_m, wider, 0.03);
    EXPECT_NEAR(errors->median_m, std::abs(wider), 0.05);
    EXPECT_NEAR(errors->rms_m, std::hypot(wider, 0.1 / std::sqrt(12.0)), 0.03);
    EXPECT_NEAR(errors->share_within, wider == 0 ? 1 : 0, 0.15);
  }
}

TEST(WallErrors, SlopesAndWallsInHolesAreNotLookedAt) {
  const auto slope = [](double x, double) { return float(x); };
  EXPECT_EQ(wall_errors(field_of(0.1, 400, slope), field_of(0.1, 400, slope), 0.1, collinea::Run{})->samples, 0u);
  const auto rim = [](double x, double y) { return y < 20 ? kNone : rotated_block(x, y, 0); };  // of the truth
  const HeightField whole = field_of(0.1, 400, [](double x, double y) { return rotated_block(x, y, 0); });
  const auto at_rim = wall_errors(whole, field_of(0.1, 400, rim), 0.1, collinea::Run{});
  ASSERT_TRUE(at_rim);
  EXPECT_GT(at_rim->samples, 0u);
  EXPECT_LT(at_rim->rms_m, 0.1);
  const auto holed = [](double x, double y) { return std::abs(x - 20) < 7 ? kNone : rotated_block(x, y, 0); };
  const HeightField truth = field_of(0.1, 400, [](double x, double y) { return rotated_block(x, y, 0); });
  const auto errors = wall_errors(field_of(0.1, 400, holed), truth, 0.1, collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_LT(errors->samples, 60u);
}

TEST(SurfaceErrors, MeasuredAndInterpolatedCellsAreToldApart) {
  const auto model = [](double x, double y) { return height_at(x, y) + (x < 10 ? 1.0f : 0.1f); };
  const StateReader state = [](int column, int, int width, int height) -> Result<Raster<std::uint8_t>> {
    Raster<std::uint8_t> states(width, height, 1, 1);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) states.at(x, y) = column + x < 100 ? 2 : 1;
    return states;
  };
  const auto errors =
      surface_errors(field_of(0.1, 400, model), state, field_of(0.1, 400, height_at), {}, nullptr, collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->smooth_interpolated.rmse_m, 1, 1e-5);
  EXPECT_NEAR(errors->smooth_measured.rmse_m, 0.1, 1e-5);
  EXPECT_EQ(errors->smooth_interpolated.cells, 40'000u);
  EXPECT_EQ(errors->smooth_measured.cells + errors->smooth_interpolated.cells, errors->smooth_ground.cells);
  EXPECT_EQ(errors->smooth_interpolated.share_gross, 1);
}

// A gabled roof over level ground: its slopes count as roof, its walls as nothing.
TEST(SurfaceErrors, RoofsAreJudgedByThemselvesAndSigmasByTheErrors) {
  const auto truth = [](double x, double y) {
    const bool house = std::abs(x - 20) < 6 && std::abs(y - 20) < 4;
    return house ? float(9 - 0.8 * std::abs(y - 20)) : 2.0f;
  };
  Random random(5);
  HeightField model =
      field_of(0.1, 400, [&](double x, double y) { return truth(x, y) + float(0.1 * random.normal()); });
  const HeightField ground = field_of(0.1, 400, [](double, double) { return 2.0f; });
  const auto judged = [&](float sigma) {
    model.read_sigma = [sigma](int, int, int width, int height) -> Result<FloatImage> {
      return FloatImage(width, height, 1, sigma);
    };
    return surface_errors(model, nullptr, field_of(0.1, 400, truth), {}, nullptr, collinea::Run{}, &ground);
  };
  const auto honest = judged(0.1f), proud = judged(0.05f);
  ASSERT_TRUE(honest && proud);
  EXPECT_NEAR(double(honest->roofs.cells), 12 * 8 * 100, 2000);
  EXPECT_NEAR(honest->roofs.rmse_m, 0.1, 0.01);
  EXPECT_NEAR(honest->within_bounds, 0.95, 0.005);
  EXPECT_NEAR(proud->within_bounds, 0.673, 0.01);  // 0.98 sigma of a normal error
  EXPECT_NEAR(proud->roofs_within_bounds, 0.673, 0.02);
  EXPECT_GT(honest->bounds, 140'000u);
}

// Errors of a tilted plane, and some that are of another surface, on one side.
TEST(TakeOffPlane, WhatIsGrossDoesNotTiltIt) {
  struct Gross {
    double share, error_m;
    float sigma_m;
  };
  for (const Gross gross : {Gross{0.02, 10, 0.02f}, {0.2, 3, 0.02f}, {0.02, 10, 5}, {0.02, 10, 1e-6f}}) {
    Random random(9);
    std::vector<LocatedError> errors;
    std::vector<bool> good;
    for (int i = 0; i < 10'000; ++i) {
      const double east = random.uniform(0, 100), north = random.uniform(0, 200);
      good.push_back(!(east > 50 && random.uniform() < 2 * gross.share));
      const double plane = 400 + 0.03 * east - 0.02 * north;
      errors.push_back({east, north, float(plane + 0.02 * random.normal() + (good.back() ? 0 : gross.error_m)),
                        good.back() ? 0.02f : gross.sigma_m});
    }
    ASSERT_TRUE(take_off_plane(errors));
    int within = 0, all = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (!good[i]) continue;
      ++all;
      within += std::abs(errors[i].error_m) <= kBoundSigmas * double(errors[i].sigma_m);
    }
    EXPECT_NEAR(double(within) / all, 0.95, 0.01) << gross.share << ' ' << gross.sigma_m;
  }
}

// Whether sigmas tell errors is not known where no plane can be taken off.
TEST(CloudErrors, OfPointsOnALineNothingIsStated) {
  const TestFolder folder;
  std::vector<CloudPoint> points(100);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].position = {2 + 0.3 * double(i), 20, 500};
    points[i].sigma_m = 0.1f;
  }
  auto writer = LasWriter::create(folder / "cloud.las", {.lowest = {0, 0, 0}, .highest = {40, 40, 600}});
  ASSERT_TRUE(writer && writer->write(points) && writer->finish());
  const HeightField truth = field_of(0.1, 400, [](double, double) { return 5.0f; });
  const auto errors = cloud_errors(folder / "cloud.las", truth, collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->points, 0u);
}

// Points of a tilted plane, whose sigmas are right for two images and half for three; some lie on something else.
TEST(CloudErrors, AreStatedInSigmasByTheNumberOfImages) {
  const TestFolder folder;
  Random random(7);
  std::vector<CloudPoint> points;
  for (int i = 0; i < 20'000; ++i) {
    CloudPoint point;
    const double x = random.uniform(1, 39), y = random.uniform(1, 39);
    point.images = std::uint8_t(2 + i % 2);
    point.sigma_m = 0.1f / float(1 + i % 2);
    point.position = {x, y, 5 + 0.01 * x + 0.1 * random.normal() + (i % 100 == 0 ? 3 : 0)};
    points.push_back(point);
  }
  auto writer = LasWriter::create(folder / "cloud.las", {.lowest = {0, 0, 0}, .highest = {40, 40, 10}});
  ASSERT_TRUE(writer && writer->write(points) && writer->finish());
  const HeightField truth = field_of(0.1, 400, [](double, double) { return 5.0f; });
  const auto errors = cloud_errors(folder / "cloud.las", truth, collinea::Run{});
  ASSERT_TRUE(errors) << errors.error().message;
  EXPECT_EQ(errors->points, points.size());
  ASSERT_EQ(errors->by_images.size(), 2u);
  EXPECT_EQ(errors->by_images[0].images, 2);
  EXPECT_NEAR(errors->by_images[0].rms, 1, 0.05);
  EXPECT_NEAR(errors->by_images[1].rms, 2 * 0.955, 0.1);  // cut off at 2.5 of their real sigmas
  EXPECT_NEAR(errors->share_gross, 0.01 + 0.0124 / 2, 0.005);
  EXPECT_NEAR(errors->within_bounds, (0.95 + 0.673) / 2 - 0.01, 0.015);
}

// What a block's orientation does to all heights is not what their relative sigmas tell of.
TEST(SurfaceErrors, RelativeSigmasAreJudgedLessThePlaneThatAllErrorsShare) {
  Random random(6);
  HeightField model = field_of(0.1, 400, [&](double x, double y) {
    return height_at(x, y) + float(0.1 * random.normal() + 0.5 + 0.02 * x - 0.03 * y);
  });
  model.read_sigma = [](int, int, int width, int height) -> Result<FloatImage> {
    return FloatImage(width, height, 1, 0.1f);
  };
  const auto errors = surface_errors(model, nullptr, field_of(0.1, 400, height_at), {}, nullptr, collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_LT(errors->within_bounds, 0.5);
  EXPECT_NEAR(errors->levelled_within_bounds.value(), 0.95, 0.01);
}

TEST(SurfaceErrors, OnlyWhatThreeCamerasSeeMustBeThere) {
  Survey survey;
  const std::vector<View> views = views_of(survey.block, nullptr);
  const auto model = [](double x, double y) { return x < 10 && y < 10 ? height_at(x, y) : kNone; };
  const auto errors = surface_errors(field_of(0.2, 500, model), nullptr, field_of(0.2, 500, height_at), views, nullptr,
                                     collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->completeness, 0.01, 1e-3);
  EXPECT_GT(errors->cells_seen, 300u);
  EXPECT_LT(errors->cells_seen, 5000u);
  EXPECT_GT(errors->completeness_seen, 0.1);
}

float ground_at(double x, double) { return float(0.1 * x); }

// The block is 4 to 3 m above the ground. A fifth of it, a strip of 2 m, was left standing.
TEST(TerrainErrors, WhatWasRemovedAndHowWellTheGroundWasMet) {
  const auto left_standing = [](double x, double y) { return x > 28 && height_at(x, y) == 5; };
  const auto model = [&](double x, double y) {
    return left_standing(x, y) ? 5 : ground_at(x, y) + (height_at(x, y) == 5 ? 0.2f : 0.1f);
  };
  const HeightField field = field_of(0.1, 400, model);
  const StateReader state = [&](int column, int row, int width, int rows) -> Result<Raster<std::uint8_t>> {
    Raster<std::uint8_t> states(width, rows);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < width; ++x) {
        const double east = field.grid.east_of(column + x + 0.5), north = field.grid.north_of(row + y + 0.5);
        const bool covered = height_at(east, north) == 5 && !left_standing(east, north);
        states.at(x, y) = std::uint8_t(covered ? CellState::kInterpolated : CellState::kMeasured);
      }
    return states;
  };
  const auto errors =
      terrain_errors(field, state, field_of(0.1, 400, ground_at), field_of(0.1, 400, height_at), collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->object_cells, 10000u);
  EXPECT_NEAR(errors->share_removed, 0.8, 1e-12);
  EXPECT_EQ(errors->interpolated.cells, 8000u);
  EXPECT_NEAR(errors->interpolated.rmse_m, 0.2, 1e-5);
  EXPECT_EQ(errors->measured.cells, 152000u);
  EXPECT_NEAR(errors->measured.median_m, 0.1, 1e-5);
  const HeightField elsewhere = field_of(0.1, 10, [](double, double) { return kNone; });
  EXPECT_FALSE(terrain_errors(field, state, elsewhere, elsewhere, collinea::Run{}));
}

TEST(SurfaceErrors, RastersThatDoNotMeetAreAnError) {
  HeightField away = field_of(0.1, 50, height_at);
  away.grid.west_m = 1000;
  EXPECT_FALSE(surface_errors(away, nullptr, field_of(0.1, 50, height_at), {}, nullptr, collinea::Run{}));
}

ImageField image_of(double cell_m, int side, double shift_x_m, double shift_y_m) {
  ImageField field;
  field.grid = {0, side * cell_m, cell_m, side, side, ""};
  field.read = [grid = field.grid, shift_x_m, shift_y_m](int column, int row, int width,
                                                         int rows) -> Result<Raster<std::uint8_t>> {
    Raster<std::uint8_t> image(width, rows, 4, 255);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < width; ++x) {
        const double e = grid.east_of(column + x + 0.5) - shift_x_m, n = grid.north_of(row + y + 0.5) - shift_y_m;
        const double v = 120 + 40 * std::sin(7 * e + 2 * std::sin(n)) + 40 * std::sin(6 * n + std::cos(1.3 * e));
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = std::uint8_t(std::lround(v));
        if (e > 25 && n > 25) image.at(x, y, 3) = 0;
      }
    }
    return image;
  };
  return field;
}

TEST(OrthoErrors, AShiftIsFoundToAFewHundredthsOfAPixel) {
  const auto errors = ortho_errors(image_of(0.1, 400, 0.13, -0.24), image_of(0.05, 800, 0, 0), collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_GT(errors->windows, 30u);
  EXPECT_EQ(errors->share_failed, 0);
  EXPECT_NEAR(errors->mean_x_px, 1.3, 0.05);
  EXPECT_NEAR(errors->mean_y_px, 2.4, 0.05);
  EXPECT_NEAR(errors->rms_x_px, 1.3, 0.06);
  EXPECT_EQ(errors->share_over_1_px, 1);
}

TEST(OrthoErrors, WhatIsFurtherAwayThanTheSearchFails) {
  ImageField grey = image_of(0.1, 400, 0, 0);
  grey.read = [](int, int, int width, int rows) -> Result<Raster<std::uint8_t>> {
    return Raster<std::uint8_t>(width, rows, 1, 99);
  };
  const auto errors = ortho_errors(grey, image_of(0.1, 400, 0, 0), collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->share_failed, 1);
  EXPECT_FALSE(ortho_errors(image_of(0.1, 400, 0, 0), grey, collinea::Run{}));  // no texture to look for
}

}  // namespace
}  // namespace collinea
