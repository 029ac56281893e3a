// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/adjustment_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/block/gnss_vector.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/test_damage.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kNaN = std::numeric_limits<double>::quiet_NaN();

const std::string kSmall =
    "collinea-adjustment 1\n"                      // 1
    "# two images, one point\n"                    // 2
    "camera wide 4000 3000 brown\n"                // 3
    "parameter wide f 3600.5 free\n"               // 4
    "parameter wide k1 -0.02 0.01 -0.03\n"         // 5
    "image \"left one.jpg\" wide   # a remark\n"   // 6
    "image b wide\n"                               // 7
    "pose \"left one.jpg\" 0 0 50 0 0 90 fixed\n"  // 8
    "position b 10 0 - 0.5 0.5 -\n"                // 9
    "control G1 1 2 3 0 0 -\n"                     // 10
    "check \"a \"\"b\"\"\" 1 2 3 0.1 0.1 0.2\n"    // 11
    "point 7 5 5 1\n"                              // 12
    "measured_control b G1 100.5 200 0.3\n"        // 13
    "measured_tie b 7 1 2 0.5\n"                   // 14
    "measured_tie \"left one.jpg\" 7 3 4 0.5\n";   // 15

TEST(AdjustmentFile, IsReadAsItSays) {
  const auto file = parse_adjustment_file(kSmall);
  ASSERT_TRUE(file) << file.error().message;
  const Block& block = file->block;
  const Camera& camera = block.cameras.at({0});
  EXPECT_EQ(camera.params[Camera::kF], 3600.5);
  EXPECT_EQ(camera.params[Camera::kCx], 2000);  // not stated: the middle, fixed
  EXPECT_EQ(file->camera_sigmas.at({0})[Camera::kCx], 0);
  EXPECT_EQ(file->camera_sigmas.at({0})[Camera::kF], kInfinity);
  EXPECT_EQ(file->camera_sigmas.at({0})[Camera::kK1], 0.01);
  EXPECT_EQ(camera.params[Camera::kK1], -0.02);
  EXPECT_EQ(file->given_cameras.at({0}).params[Camera::kK1], -0.03);
  EXPECT_EQ(block.images.at({0}).file, "left one.jpg");
  EXPECT_TRUE(file->fixed_images.contains({0}));
  EXPECT_LT((centre_of(pose_of(block, {0})) - Eigen::Vector3d(0, 0, 50)).norm(), 1e-14);
  EXPECT_FALSE(is_oriented(block, {1}));
  EXPECT_EQ(block.images.at({1}).position->sigma_m.z(), kInfinity);
  EXPECT_EQ(block.control.at({0}).sigma_m, Eigen::Vector3d(0, 0, kInfinity));
  EXPECT_EQ(block.control.at({1}).name, "a \"b\"");
  EXPECT_EQ(block.control.at({1}).role, ControlRole::kCheck);
  ASSERT_EQ(block.observations.size(), 2u);
  EXPECT_EQ(block.observations[0].image, ImageId{0});  // sorted by point and image
  EXPECT_EQ(block.observations[0].pixel, Eigen::Vector2d(3, 4));
  EXPECT_EQ(block.control_observations.at(0).sigma_px, 0.3);
}

// Everything an adjustment knows, with names that need quotes and names that occur twice.
AdjustmentFile random_file() {
  Random random(5);
  AdjustmentFile file;
  Block& block = file.block;
  block.georeference = Georeference{"EPSG:32633", 48.1, 15.3, 312.25};
  for (std::uint32_t c = 0; c < kCameraModels.size(); ++c) {
    Camera camera = ideal_camera(3000 + random.normal(), 4000, 3000);
    camera.model = kCameraModels[c];
    if (c != 1) camera.additional = AdditionalSet((c + 1) % kAdditionalNames.size());
    camera.name = "same # name";
    for (const int k : params_of(camera)) camera.params[std::size_t(k)] += 1e-3 * random.normal();
    block.cameras[{c}] = camera;
    for (const int k : params_of(camera)) camera.params[std::size_t(k)] += 1e-3 * random.normal();
    file.given_cameras[{c}] = camera;
    file.camera_sigmas[{c}].fill(0);
    for (const int k : params_of(camera))
      file.camera_sigmas[{c}][std::size_t(k)] = k % 3 == 0 ? 0 : k % 3 == 1 ? kInfinity : random.uniform(0.1, 2);
  }
  file.corrected_cameras.insert({1});
  for (std::uint32_t i = 0; i < 6; ++i) {
    block.images[{i}] = {.file = i < 2 ? "IMG.jpg" : "a\"" + std::to_string(i), .camera = {i % 2}};
    if (i == 4) continue;
    const Eigen::Vector3d rotation(random.normal(), random.normal(), random.normal());
    set_pose(block, {i}, {rotation_by(rotation), 100 * rotation});
    if (i == 2)
      block.images[{i}].position = PositionPrior{{random.normal(), random.normal(), kNaN}, {0.1, 0.2, kInfinity}};
  }
  file.fixed_images.insert({3});
  for (std::uint32_t p = 0; p < 3; ++p)
    block.control[{p}] = {.name = std::to_string(p),
                          .role = p == 1 ? ControlRole::kCheck : ControlRole::kControl,
                          .position_in_map = {},
                          .position_in_world = {random.normal(), 1e6 * random.normal(), p == 2 ? kNaN : 1.0},
                          .sigma_m = {0, 0.01, p == 2 ? kInfinity : 0.02}};
  block.control.at({1}).correlation = {1.0 / 3, -0.25, 0.1};
  for (std::uint32_t p = 0; p < 5; ++p) {
    if (p != 3) block.points[{p}] = {{random.normal(), random.normal(), random.normal()}, {}};
    for (std::uint32_t i = 0; i < 6; ++i)
      block.observations.push_back({{i}, {p}, 0, {random.uniform(0, 4000), random.uniform(0, 3000)}, 0.5});
  }
  for (std::uint32_t i = 0; i < 6; ++i)
    block.control_observations.push_back({{i % 3}, {i}, {random.uniform(0, 4000), random.uniform(0, 3000)}, 0.25});
  for (std::size_t kind = 0; kind < kGeodeticKinds; ++kind) {
    GeodeticObservation one{
        .kind = GeodeticKind(kind), .from = {0}, .to = {2}, .value = 1 + random.uniform(), .sigma = 0.01};
    if (one.kind == GeodeticKind::kGnssVector) continue;  // three together: GnssVectorsComeBack
    if (kind == 1) one.role = ControlRole::kCheck;
    if (kind > 1) one.setup = 3, one.instrument_height_m = 1.51;
    if (one.is_of_shape()) {
      one = {.kind = one.kind, .name = "the wall", .from = {1}, .to = {1}, .sigma = 0.02, .setup = 0};
      if (one.kind == GeodeticKind::kOnLine) one.axis = 1, one.role = ControlRole::kCheck;
    }
    block.geodetic.push_back(one);
  }
  for (auto& [id, image] : block.images) image.taken = "2024:05:17 10:31:0" + std::to_string(id.value);
  Instruments& instruments = file.instruments;
  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kInfinity);
  instruments.attitudes[{2}] = {rotation_by({0.1, 0.2, -0.3}), {0.001, 0.002, 0.003}};
  instruments.boresight_sigma_rad[{1}] = unknown;
  instruments.lever_arms[{0}] = {{0.1, -0.2, 0.3}, {0, 0, 0}};
  instruments.lever_arms[{1}] = {{0, 0, 0}, unknown};
  instruments.position_tracks = {{{{{2}, -1.25}, {{3}, 1.25}}, unknown, {0.01, 0.02, 0.03}}, {{{{5}, 0}}, {1, 1, 1}}};
  instruments.time_offset_sigma_s = {{{0}, 0.5}, {{1}, kInfinity}};
  instruments.velocity_m_s[{2}] = {random.normal(), random.normal(), random.normal()};
  return file;
}

TEST(AdjustmentFile, RoundTripKeepsEverything) {
  const AdjustmentFile file = random_file();
  const std::string text = adjustment_file_text(file);
  const auto back = parse_adjustment_file(text);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->camera_sigmas, file.camera_sigmas);
  EXPECT_EQ(back->fixed_images, file.fixed_images);
  EXPECT_EQ(back->corrected_cameras, file.corrected_cameras);
  EXPECT_EQ(back->block.georeference->crs, "EPSG:32633");
  EXPECT_EQ(back->block.georeference->origin_height_m, 312.25);
  for (const auto& [id, camera] : file.block.cameras) {
    EXPECT_EQ(back->block.cameras.at(id).params, camera.params);
    EXPECT_EQ(back->block.cameras.at(id).model, camera.model);
    EXPECT_EQ(back->block.cameras.at(id).additional, camera.additional);
    for (std::size_t k = 0; k < camera.params.size(); ++k) {
      const double sigma = file.camera_sigmas.at(id)[k];
      if (sigma > 0 && std::isfinite(sigma)) {
        EXPECT_EQ(back->given_cameras.at(id).params[k], file.given_cameras.at(id).params[k]);
      }
    }
  }
  ASSERT_EQ(count_oriented(back->block), count_oriented(file.block));
  for (const auto& [id, pose] : oriented_images(file.block)) {
    EXPECT_LT(angle_between(pose_of(back->block, id).rotation, pose.rotation), 1e-14);
    EXPECT_LT((centre_of(pose_of(back->block, id)) - centre_of(pose)).norm(), 1e-12);
  }
  EXPECT_EQ(back->block.images.at({2}).position->sigma_m, file.block.images.at({2}).position->sigma_m);
  for (const auto& [id, control] : file.block.control) {
    EXPECT_EQ(back->block.control.at(id).name, control.name);
    EXPECT_EQ(back->block.control.at(id).role, control.role);
    EXPECT_EQ(back->block.control.at(id).sigma_m, control.sigma_m);
    EXPECT_EQ(back->block.control.at(id).correlation, control.correlation);
    EXPECT_EQ(back->block.control.at(id).position_in_world.y(), control.position_in_world.y());
  }
  ASSERT_EQ(back->block.geodetic.size(), kGeodeticKinds - 1);
  for (std::size_t i = 0; i < back->block.geodetic.size(); ++i) {
    const GeodeticObservation &one = back->block.geodetic[i], &before = file.block.geodetic[i];
    EXPECT_EQ(one.kind, before.kind);
    EXPECT_EQ(one.from, before.from);
    EXPECT_EQ(one.to, before.to);
    EXPECT_NEAR(one.value, before.value, 1e-15);  // angles go through degrees
    EXPECT_NEAR(one.sigma, before.sigma, 1e-17);
    EXPECT_EQ(one.role, before.role);
    EXPECT_EQ(one.setup, before.setup);
    EXPECT_EQ(one.instrument_height_m, before.instrument_height_m);
    EXPECT_EQ(one.target_height_m, before.target_height_m);
    EXPECT_EQ(one.axis, before.axis);
    if (one.is_of_shape()) {
      EXPECT_EQ(one.name, before.name);
    }
  }
  EXPECT_EQ(back->block.images.at({4}).taken, file.block.images.at({4}).taken);
  const Instruments &instruments = back->instruments, &given = file.instruments;
  ASSERT_EQ(instruments.attitudes.size(), 1u);
  EXPECT_LT(angle_between(instruments.attitudes.at({2}).cam_from_world, given.attitudes.at({2}).cam_from_world), 1e-14);
  EXPECT_LT((instruments.attitudes.at({2}).sigma_rad - given.attitudes.at({2}).sigma_rad).norm(), 1e-17);
  EXPECT_EQ(instruments.boresight_sigma_rad, given.boresight_sigma_rad);
  ASSERT_EQ(instruments.lever_arms.size(), 2u);
  for (const auto& [id, arm] : given.lever_arms) {
    EXPECT_EQ(instruments.lever_arms.at(id).antenna_in_cam_m, arm.antenna_in_cam_m);
    EXPECT_EQ(instruments.lever_arms.at(id).sigma_m, arm.sigma_m);
  }
  ASSERT_EQ(instruments.position_tracks.size(), 2u);
  for (std::size_t t = 0; t < 2; ++t) {
    EXPECT_EQ(instruments.position_tracks[t].time, given.position_tracks[t].time);
    EXPECT_EQ(instruments.position_tracks[t].shift_sigma_m, given.position_tracks[t].shift_sigma_m);
    EXPECT_EQ(instruments.position_tracks[t].drift_sigma_m, given.position_tracks[t].drift_sigma_m);
  }
  EXPECT_EQ(instruments.time_offset_sigma_s, given.time_offset_sigma_s);
  EXPECT_EQ(instruments.velocity_m_s, given.velocity_m_s);
  ASSERT_EQ(back->block.observations.size(), file.block.observations.size());
  for (std::size_t i = 0; i < file.block.observations.size(); ++i) {
    EXPECT_EQ(back->block.observations[i].pixel, file.block.observations[i].pixel);
    EXPECT_EQ(back->block.observations[i].image, file.block.observations[i].image);
  }
  ASSERT_EQ(back->block.points.size(), file.block.points.size());
  for (const auto& [id, point] : file.block.points)
    EXPECT_EQ(back->block.points.at(id).position_in_world, point.position_in_world);
}

TEST(AdjustmentFile, APointMeasuredInTwoImagesNeedsNoLineOfItsOwn) {
  const std::string text =
      "collinea-adjustment 1\ncamera wide 4000 3000 brown\nparameter wide f 3000 fixed\nimage a wide\nimage b wide\n"
      "ground distance T1 T2 1.5 0.001 control\n"
      "measured_control a T1 10 20 0.5\nmeasured_control b T1 30 20 0.5\nmeasured_control a T2 10 90 0.5\n";
  const auto file = parse_adjustment_file(text + "measured_control b T2 30 90 0.5\n");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->block.control.size(), 2u);
  const ControlPoint& point = file->block.control.at(file->block.geodetic.at(0).to);
  EXPECT_EQ(point.name, "T2");
  EXPECT_TRUE(point.sigma_m.array().isInf().all());
  const auto again = parse_adjustment_file(adjustment_file_text(*file));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->block.control.size(), 2u);
  const auto once = parse_adjustment_file(text);
  ASSERT_FALSE(once);
  EXPECT_TRUE(once.error().message.starts_with("line 9: there is no control or check point \"T2\""))
      << once.error().message;
  EXPECT_TRUE(once.error().message.ends_with("or measure it in a second image"));
}

TEST(AdjustmentFile, MeasurementsMayHaveACovariance) {
  const std::string text =
      "collinea-adjustment 1\ncamera wide 4000 3000 brown\nparameter wide f 3000 fixed\nimage a wide\nimage b wide\n"
      "control T1 1 2 3 0 0 0\n"
      "measured_control a T1 10 20 0.5 0.3 -0.25\nmeasured_control b T1 30 20 0.7 0.1\n"
      "measured_tie a 7 10 90 0.3\nmeasured_tie b 7 10 90 0.3 0.9 0.1\n";
  const auto file = parse_adjustment_file(text);
  ASSERT_TRUE(file) << file.error().message;
  const Block& block = file->block;
  EXPECT_LT((block.control_observations[0].sigmas_px() - Eigen::Vector2d(0.5, 0.3)).norm(), 1e-7);
  EXPECT_EQ(block.control_observations[0].shape.correlation, -0.25F);
  EXPECT_TRUE(block.observations[0].shape.is_round());
  EXPECT_LT((block.observations[1].sigmas_px() - Eigen::Vector2d(0.3, 0.9)).norm(), 1e-7);
  const std::string written = adjustment_file_text(*file);
  for (const char* line : {"measured_control a T1 10 20 0.5 0.3 -0.25\n", "measured_control b T1 30 20 0.7 0.1\n",
                           "measured_tie a 7 10 90 0.3\n", "measured_tie b 7 10 90 0.3 0.9 0.1\n"})
    EXPECT_NE(written.find(line), std::string::npos) << line << written;
  for (const char* wrong : {"0.3 0", "0.3 -1", "0.3 0.3 1", "0.3 0.3 -2"}) {
    const auto refused = parse_adjustment_file(text + "measured_tie a 8 1 2 " + wrong + "\n");
    ASSERT_FALSE(refused) << wrong;
    EXPECT_TRUE(refused.error().message.starts_with("line 11: this is no covariance")) << refused.error().message;
  }
}

TEST(AdjustmentFile, GnssVectorsComeBack) {
  const std::string head =
      "collinea-adjustment 1\ncamera wide 4000 3000 brown\nparameter wide f 3000 fixed\nimage a wide\nimage b wide\n"
      "control T1 1 2 3 0 0 0\ncontrol T2 - - - - - -\nmeasured_control a T1 10 20 0.5\n";
  const std::string vectors =
      "vector local T1 T2 10 20 30 4e-6 1e-6 0 5e-6 -1e-6 9e-6 control 1.5 0.2\n"
      "vector geocentric T1 T2 10 20 30 4e-6 1e-6 0 5e-6 -1e-6 9e-6 check\n";
  const auto file = parse_adjustment_file(head + "georeference EPSG:32633 48 15 300\n" + vectors);
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->block.geodetic.size(), 6u);
  EXPECT_EQ(file->block.geodetic[0].instrument_height_m, 1.5);
  EXPECT_TRUE(file->block.geodetic[0].is_local);
  EXPECT_EQ(file->block.geodetic[5].role, ControlRole::kCheck);
  EXPECT_NE(file->block.geodetic[5].setup, file->block.geodetic[0].setup);
  const auto again = parse_adjustment_file(adjustment_file_text(*file));
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->block.geodetic.size(), 6u);
  for (const std::size_t first : {0u, 3u}) {
    const auto& all = file->block.geodetic;
    const auto& back = again->block.geodetic;
    const GnssVector one = vector_of({all[first], all[first + 1], all[first + 2]}),
                     other = vector_of({back[first], back[first + 1], back[first + 2]});
    EXPECT_LT((one.vector - other.vector).norm(), 1e-12);
    EXPECT_LT((one.covariance_m2 - other.covariance_m2).norm(), 1e-18);
    EXPECT_EQ(one.is_local, other.is_local);
  }
  const auto error = [&](const std::string& text) { return parse_adjustment_file(head + text).error().message; };
  EXPECT_TRUE(error(vectors).starts_with("line 10: a geocentric vector needs to know where the frame is"));
  EXPECT_TRUE(
      error("vector map T1 T2 1 2 3 1 0 0 1 0 1 check\n").starts_with("line 9: \"map\" are no axes of a vector"));
  EXPECT_TRUE(error("vector local T1 T2 1 2 3 1 2 0 1 0 1 check\n").starts_with("line 9: this is no covariance"));
  EXPECT_TRUE(error("vector local T1 T2 1 2 3 1 0 0 1 0 1 check 1\n").starts_with("line 9: behind the role"));
}

TEST(AdjustmentFile, ADeflectionBelongsToAGeoreference) {
  const std::string head =
      "collinea-adjustment 1\ncamera wide 4000 3000 brown\nparameter wide f 3000 fixed\nimage a wide\n"
      "control T1 1 2 3 0 0 0\nmeasured_control a T1 10 20 0.5\ndeflection 7.5 -3\n";
  const auto file = parse_adjustment_file(head + "georeference EPSG:32633 48 15 300\n");
  ASSERT_TRUE(file) << file.error().message;
  constexpr double kArcseconds = 180 * 3600 / std::numbers::pi;
  EXPECT_NEAR(file->block.georeference->deflection_north_rad * kArcseconds, 7.5, 1e-12);
  EXPECT_NEAR(file->block.georeference->deflection_east_rad * kArcseconds, -3, 1e-12);
  const auto again = parse_adjustment_file(adjustment_file_text(*file));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_NEAR(again->block.georeference->deflection_north_rad * kArcseconds, 7.5, 1e-12);
  EXPECT_EQ(parse_adjustment_file(head).error().message,
            "line 7: a deflection is that from the ellipsoid: there is no line georeference");
  EXPECT_EQ(parse_adjustment_file(head + "deflection 1 1\n").error().message, "line 8: a second deflection");
}

TEST(AdjustmentFile, SaysInWhichLineWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"measured_tie b 7 1 2 0.5\n", "line 16: point \"7\" is measured twice in \"b\", before in line 14"},
      {"measured_tie b G1 1 2 0.5\n", "line 16: \"G1\" is no number of a tie point"},
      {"measured_control b G9 1 2 0.5\n", "line 16: there is no control or check point \"G9\""},
      {"measured_tie c 8 1 2 0.5\n", "line 16: there is no image \"c\" above"},
      {"measured_tie b 8 1 2\n", "line 16: measured_tie has 4 words behind it; expected: measured_tie IMAGE"},
      {"measured_tie b 8 1 2 0\n", "line 16: the standard deviation of a measurement is above 0"},
      {"measured_tie b 8 1 2,5 1\n", "line 16: \"2,5\" is not a row: a number is expected"},
      {"measured_tie b 8 nan 2 1\n", "line 16: \"nan\" is not a column"},
      {"mesured_tie b 8 1 2 1\n", "line 16: \"mesured_tie\" is no keyword; a line begins with one of"},
      {"camera wide 10 10 brown\n", "line 16: a second camera"},
      {"camera new 10 0 brown\n", "line 16: width and height"},
      {"camera new 10 10 fisheye\n", "line 16: \"fisheye\" is no model of cameras; there are: brown brown_of_measured"},
      {"camera new 10 10 brown sigmas_after_correction\n", "line 16: behind the model"},
      {"camera new 10 10 brown\n", "camera \"new\" has no focal length"},
      {"camera new 10 10 brown cheese\n", "line 16: behind the model"},
      {"camera new 10 10 equidistant ebner\nparameter new a13 1 free\n", "line 17: \"a13\" is no parameter of this"},
      {"parameter wide k4 1 free\n", "line 16: \"k4\" is no parameter of this camera"},
      {"parameter wide f 1 free\n", "line 16: f of camera wide is given twice"},
      {"parameter wide q 1 free\n", "line 16: \"q\" is no parameter of this camera; there are: f cx cy k1"},
      {"parameter wide k2 1 frei\n", "line 16: \"frei\" says not how the parameter takes part"},
      {"parameter wide k2 1 free 2\n", "line 16: a given value belongs to a standard deviation"},
      {"ground distance G1 G9 3 0.01 control\n", "line 16: there is no control or check point \"G9\""},
      {"ground distance G1 G1 3 0.01 control\n", "line 16: a measurement from a point to itself"},
      {"ground distance G1 G9 0 0.01 control\n", "line 16: a distance is above 0"},
      {"ground distance G1 G9 3 0 control\n", "line 16: the standard deviation of a measurement is above 0"},
      {"ground distance G1 G9 3 0.01 checked\n", "line 16: \"checked\" is no role: control or check"},
      {"ground tape G1 G9 3 0.01 check\n", "line 16: \"tape\" is measured by nobody; there are: distance"},
      {"ground direction G1 G9 3 0.01 check\n", "line 16: a direction belongs to a set-up"},
      {"ground direction G1 G9 3 0.01 check x 0 0\n", "line 16: \"x\" is no set-up"},
      {"ground direction G1 G9 3 0.01 check 1 0\n", "line 16: behind the role stand"},
      {"image b wide\n", "line 16: a second image \"b\""},
      {"image c narrow\n", "line 16: there is no camera \"narrow\" above"},
      {"pose b 0 0 0 0 0 0 free\n", "line 16: behind kappa stands fixed or nothing"},
      {"position \"left one.jpg\" 0 0 0 0 0 0\n", "line 16: a measured position has standard deviations above 0"},
      {"control G1 1 2 3 1 1 1\n", "line 16: a second point \"G1\""},
      {"control G2 1 2 - 1 1 1\n", "line 16: a coordinate is not given (-), but its standard deviation is"},
      {"control G2 1 2 3 1 1 -1\n", "line 16: \"-1\" is not a standard deviation"},
      {"point P7 1 2 3\n", "line 16: \"P7\" is no number of a tie point"},
      {"point 7 1 2 3\n", "line 16: a second tie point 7"},
      {"georeference EPSG:32633 100 10 0\n", "line 16: no such latitude and longitude"},
      {"image \"c\n", "line 16: a name in quotes does not end"},
  };
  for (const auto& [line, message] : cases) {
    const auto file = parse_adjustment_file(kSmall + line);
    ASSERT_FALSE(file) << line;
    EXPECT_EQ(file.error().code, Errc::kBadFormat);
    EXPECT_NE(file.error().message.find(message), std::string::npos) << line << file.error().message;
  }
  EXPECT_NE(parse_adjustment_file("").error().message.find("empty"), std::string::npos);
  EXPECT_NE(parse_adjustment_file("P5\n").error().message.find("line 1: the file does not begin with"),
            std::string::npos);
  EXPECT_NE(parse_adjustment_file("collinea-adjustment 2\n").error().message.find("version"), std::string::npos);
}

// A file that breaks off is reported or is a file of fewer lines; bytes gone wrong never end the program.
TEST(AdjustmentFile, SurvivesTruncationAndGarbage) {
  const std::string text = adjustment_file_text(random_file());
  read_damaged(text, [](const std::string& broken) {
    const auto file = parse_adjustment_file(broken);
    if (!file) {
      EXPECT_FALSE(file.error().message.empty());
    }
  });
  EXPECT_TRUE(is_adjustment_file(text));
  EXPECT_FALSE(is_adjustment_file("image 1"));
}

// Lines with the head of kSmall in front and a measurement behind.
std::string error_of(const std::string& lines) {
  const auto file = parse_adjustment_file(std::string(kSmall) + lines);
  return file ? "read" : file.error().message;
}

TEST(AdjustmentFile, ControlOfAMapIsBroughtToTheFrame) {
  const auto file = parse_adjustment_file(std::string(kSmall) +
                                          "georeference EPSG:32633 48 15 300\n"
                                          "control_in_map M1 500000 5316300 310 0.01 0.01 -\n");
  ASSERT_TRUE(file) << file.error().message;
  const ControlPoint& point = file->block.control.at({2});
  EXPECT_LT((point.position_in_map - Eigen::Vector3d(500000, 5316300, 310)).norm(), 1e-6);
  EXPECT_LT(point.position_in_world.head<2>().norm(), 1000);
  EXPECT_NEAR(point.position_in_world.z(), 10, 0.1);
  EXPECT_EQ(point.sigma_m.z(), kInfinity);
  EXPECT_EQ(error_of("control_in_map M1 500000 5316300 310 0.01 0.01 0.02\n"),
            "line 16: coordinates of which map? There is no line georeference");
  EXPECT_TRUE(error_of("control_in_map M1 - - 310 - - 0.02\n").starts_with("line 16: a point of a map needs all"));
}

TEST(AdjustmentFile, WhatIsWrongWithInstrumentsAndShapesIsNamed) {
  EXPECT_EQ(error_of("attitude b 0 0 0 0.1 0 0.1\n"), "line 16: a measured attitude has standard deviations above 0");
  EXPECT_EQ(error_of("lever_arm wide 0 0 0 - - -\nlever_arm wide 0 0 0 - - -\n"),
            "line 17: a second lever_arm of \"wide\"");
  EXPECT_EQ(error_of("lever_arm narrow 0 0 0 - - -\n"), "line 16: there is no camera \"narrow\" above");
  EXPECT_EQ(error_of("boresight wide -1 0 0\n"),
            "line 16: \"-1\" is not a standard deviation: a number from 0, or - for none");
  EXPECT_TRUE(error_of("on_track b 1 0\n").starts_with("line 16: there is no track \"1\" above"));
  EXPECT_EQ(error_of("track 1 - - - 0 0 0\non_track b 1 0\non_track b 1 0\n"), "line 18: \"b\" is on a track already");
  EXPECT_EQ(error_of("lies_on sphere a G1 0.1 control\n"),
            "line 16: \"sphere\" is no shape; there are: plane line height");
  EXPECT_TRUE(error_of("lies_on plane a G1 0.1 control upwards\n").starts_with("line 16: behind the role"));
  EXPECT_TRUE(error_of("lies_on plane a G9 0.1 control\n").starts_with("line 16: there is no control or check point"));
  // A line without an axis is two observations.
  const auto file = parse_adjustment_file(std::string(kSmall) + "lies_on line kerb G1 0.01 control\n");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->block.geodetic.size(), 2u);
  EXPECT_EQ(file->block.geodetic[1].axis, 1);
}

}  // namespace
}  // namespace collinea
