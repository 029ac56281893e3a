// SPDX-License-Identifier: Apache-2.0
// Slips that no reader can see, in a flight that is otherwise good: what names each of them, and what is left of the
// flight. io/bad_input_test.cc reads the same from files, as they stand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "collinea/base/test_folder.h"
#include "collinea/report/finding_words.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/step.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

using C = FindingCode;

struct Slip {
  const char* what;
  std::function<void(Block&)> make;
  std::optional<C> code;             // nothing: it is not found, and does no harm
  std::optional<Subject> subject{};  // that the finding begins with
  double check_m = 0.1;              // RMS that check points have all the same
};

const ControlId kThird{2};
const ImageId kSixth{5};
constexpr double kFeet = 1 / 0.3048;

Eigen::Vector3d& coordinates(Block& block) { return block.control.at(kThird).position_in_world; }
PositionPrior& position(Block& block) { return *block.images.at(kSixth).position; }

// The first measurement of the third point that is still in its image with these coordinates.
std::function<void(Block&)> mark(const std::function<Eigen::Vector2d(const Camera&, const Eigen::Vector2d&)>& wrong) {
  return [wrong](Block& block) {
    for (ControlObservation& seen : block.control_observations) {
      const Camera& camera = block.camera_of(seen.image);
      const Eigen::Vector2d pixel = wrong(camera, seen.pixel);
      if (seen.point != kThird || pixel.x() > camera.width_px || pixel.y() > camera.height_px) continue;
      seen.pixel = pixel;
      return;
    }
  };
}

Eigen::Vector2d with_rows_up(const Camera& camera, const Eigen::Vector2d& pixel) {
  return {pixel.x(), camera.height_px - pixel.y()};
}

std::vector<Slip> slips_in_control() {
  const auto everywhere = [](auto&& change) {
    return [=](Block& block) {
      for (auto& [id, point] : block.control) change(point);
    };
  };
  return {
      {"a decimal slip in a coordinate", [](Block& b) { coordinates(b).x() -= 492131.079; }, C::kControlPoint, kThird},
      {"a lost sign", [](Block& b) { coordinates(b).z() -= 704.36; }, C::kControlPoint, kThird},
      {"two digits exchanged", [](Block& b) { coordinates(b).y() += 90; }, C::kControlPoint, kThird},
      {"degrees in a map of metres", [](Block& b) { coordinates(b) += Eigen::Vector3d(-546796.68, -5338053.73, 0); },
       C::kControlPoint, kThird},
      {"heights in feet",
       everywhere([](ControlPoint& p) { p.position_in_world.z() += (kFeet - 1) * 352; }),
       C::kPositionHeights,
       {},
       2000},
      {"a sigma in millimetres", [](Block& b) { b.control.at(kThird).sigma_m *= 1000; }, {}},
      {"a southern zone", everywhere([](ControlPoint& p) { p.position_in_world.y() -= 1e7; }), C::kPositionCrs},
      {"column and row exchanged", mark([](const Camera&, const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
         return {pixel.y(), pixel.x()};
       }),
       C::kControlMeasurement, kThird},
      {"a row counted upwards", mark(with_rows_up), C::kControlMeasurement, kThird},
      {"rows counted upwards",
       [](Block& block) {
         for (ControlObservation& seen : block.control_observations)
           seen.pixel = with_rows_up(block.camera_of(seen.image), seen.pixel);
       },
       C::kMarksCorrected},
  };
}

std::vector<Slip> slips_in_positions() {
  return {
      {"a decimal slip", [](Block& b) { position(b).position_in_world.x() -= 492131.079; }, C::kGrossErrorRejected,
       kSixth},
      {"a digit", [](Block& b) { position(b).position_in_world.y() += 30; }, C::kGrossErrorRejected, kSixth},
      {"a height in feet", [](Block& b) { position(b).position_in_world.z() += (kFeet - 1) * 452; },
       C::kGrossErrorRejected, kSixth},
      {"a sigma in millimetres", [](Block& b) { position(b).sigma_m *= 1000; }, {}},
      {"longitude first",
       [](Block& block) {
         for (auto& [id, image] : block.images) image.position->position_in_world += Eigen::Vector3d(3e6, -3e6, 1e6);
       },
       C::kPositionCrs},
  };
}

// A measurement from the third point to the fourth that is off by a factor, a constant or its sigma.
Slip ground(const char* what, GeodeticKind kind, double factor, double constant, double sigma, std::optional<C> code) {
  const auto make = [=](Block& block) {
    const auto at = [&](std::uint32_t point) { return block.control.at({point}).position_in_world; };
    const auto measured = [&](std::uint32_t from, std::uint32_t to) {
      const Eigen::Vector3d line = at(to) - at(from);
      if (kind == GeodeticKind::kDistance) return line.norm();
      if (kind == GeodeticKind::kZenithAngle) return std::acos(line.z() / line.norm());
      const double azimuth_rad = std::atan2(line.x(), line.y());
      return azimuth_rad < 0 ? azimuth_rad + 2 * std::numbers::pi : azimuth_rad;
    };
    const double good = kind == GeodeticKind::kDistance ? 0.01 : 1e-4;
    for (const std::uint32_t to : {0u, 1u, 4u})
      block.geodetic.push_back(
          {.kind = kind, .from = kThird, .to = {to}, .value = measured(2, to), .sigma = good, .setup = 0});
    block.geodetic.push_back({.kind = kind,
                              .from = kThird,
                              .to = {3},
                              .value = factor * measured(2, 3) + constant,
                              .sigma = sigma,
                              .setup = 0});
  };
  return {what, make, code, code ? std::optional(Subject::geodetic(3)) : std::nullopt};
}

std::vector<Slip> slips_on_the_ground() {
  constexpr double kGon = 0.9;
  const auto distance = GeodeticKind::kDistance, direction = GeodeticKind::kDirection,
             zenith = GeodeticKind::kZenithAngle;
  return {
      ground("a distance with a decimal slip", distance, 0.1, 0, 0.01, C::kGrossErrorRejected),
      ground("a distance in millimetres", distance, 1000, 0, 0.01, C::kGrossErrorRejected),
      ground("a distance with two digits exchanged", distance, 1, 0.9, 0.01, C::kGrossErrorRejected),
      ground("a sigma in millimetres", distance, 1, 0, 10, {}),
      ground("gon in a column of degrees", zenith, 1 / kGon, 0, 1e-4, C::kGrossErrorRejected),
      ground("elevation in place of zenith", zenith, -1, std::numbers::pi / 2, 1e-4, C::kGrossErrorRejected),
      ground("degrees in a column of gon", direction, kGon, 0, 1e-4, C::kGrossErrorRejected),
  };
}

class SlipTest : public ::testing::TestWithParam<double> {
 protected:
  void SetUp() override {
    SurveyOptions survey;
    survey.images = 12;
    survey.control_points = 6;
    survey.check_points = 2;
    survey.receiver.gps_sigma_plan_m = GetParam();
    survey.receiver.gps_sigma_height_m = 2 * GetParam();
    auto project = open_simulated(folder_ / "block", survey, {.points_per_image = 120});
    ASSERT_TRUE(project) << project.error().message;
    project_ = *std::move(project);
    good_ = *project_->store.read_setup();
  }
  void expect_named(const std::vector<Slip>& slips) {
    for (const Slip& slip : slips) {
      SCOPED_TRACE(slip.what);
      Block block = good_;
      slip.make(block);
      expect_named(slip, block);
    }
  }

 private:
  void expect_named(const Slip& slip, const Block& block) {
    ASSERT_TRUE(project_->store.write_setup(block));
    const auto done = bring_up_to(*project_, Step::kAdjust);
    ASSERT_TRUE(done) << done.error().message;
    const auto oriented = project_->store.read_outcome<OrientationRecord>();
    const auto adjusted = project_->store.read_outcome<AdjustmentRecord>();
    ASSERT_TRUE(oriented && adjusted);
    std::vector<Finding> findings = oriented->findings;
    findings.insert(findings.end(), adjusted->findings.begin(), adjusted->findings.end());
    std::string all;
    for (const Finding& one : findings) all += sentence_of(one, block) + "\n";
    const auto is_it = [&](const Finding& one) {
      return one.code == slip.code &&
             (!slip.subject || (!one.subjects.empty() && is_same(one.subjects[0], *slip.subject)));
    };
    if (slip.code)
      EXPECT_TRUE(std::ranges::any_of(findings, is_it)) << all;
    else
      EXPECT_TRUE(findings.empty()) << all;
    EXPECT_LT(adjusted->sigma0, 1.2) << all;
    EXPECT_LE(adjusted->rejected, 1u) << all;
    ASSERT_TRUE(adjusted->check_rmse_m) << all;
    for (const auto& check_m : *adjusted->check_rmse_m) EXPECT_LT(check_m.value(), slip.check_m) << all;
  }
  static bool is_same(const Subject& found, const Subject& wanted) {
    return found.kind == wanted.kind && found.id == wanted.id;
  }

  TestFolder folder_;
  std::optional<Project> project_;
  Block good_;
};

TEST_P(SlipTest, InControlIsNamed) { expect_named(slips_in_control()); }
TEST_P(SlipTest, InAPositionIsNamed) { expect_named(slips_in_positions()); }
TEST_P(SlipTest, OnTheGroundIsNamed) { expect_named(slips_on_the_ground()); }

INSTANTIATE_TEST_SUITE_P(Receivers, SlipTest, ::testing::Values(1.5, 0.02), [](const auto& receiver) {
  return std::string(receiver.param > 1 ? "OfMetres" : "OfCentimetres");
});

}  // namespace
}  // namespace collinea
