// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/absolute.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

// Mussio D.8: scale 1.25, Rodrigues (0.2, -0.1, 0.3) without the factor 1/2, shift (100, 200, 50).
constexpr const char* kModel = "point U V W\n1 0 0 0\n2 10 0 1\n3 0 8 -1\n4 10 8 2\n5 5 4 3\nnew 1 2 3\n";
constexpr const char* kGround =
    "point X[m] Y[m] Z[m]\n1 100 200 50\n2 110.657894737 193.355263158 50.263157895\n"
    "3 104.561403509 207.346491228 44.824561404\n4 115.921052632 201.447368421 47.368421053\n"
    "5 108.662280702 201.469298246 50.964912281\n";

class AbsoluteJob : public ::testing::Test {
 protected:
  [[nodiscard]] Result<AbsoluteReport> orient(const std::string& model, const std::string& ground,
                                              const OrientAbsoluteOptions& options = {}) const {
    EXPECT_TRUE(write_file(folder_ / "model.txt", model));
    EXPECT_TRUE(write_file(folder_ / "ground.txt", ground));
    return orient_absolutely(folder_ / "model.txt", folder_ / "ground.txt", options);
  }
  TestFolder folder_;
};

TEST_F(AbsoluteJob, EveryMethodFindsTheNumbersOfTheText) {
  for (const AbsoluteMethod method : {AbsoluteMethod::kLeastSquares, AbsoluteMethod::kUmeyama,
                                      AbsoluteMethod::kQuaternion, AbsoluteMethod::kRodrigues}) {
    OrientAbsoluteOptions options;
    options.method = method;
    const auto report = orient(kModel, kGround, options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_NEAR(report->parameters[0].value, 100, 1e-7);
    EXPECT_NEAR(report->parameters[6].value, 1.25, 1e-8);
    EXPECT_EQ(report->points.size(), 5u);
    EXPECT_EQ(report->ground.size(), 6u);
    EXPECT_NE(absolute_text(*report).find("scale"), std::string::npos);
  }
}

TEST_F(AbsoluteJob, AWrongPointIsNamedAndRejected) {
  std::string ground = kGround;
  ground.replace(ground.find("193.355"), 7, "194.355");
  OrientAbsoluteOptions options;
  options.sigma_ground = 0.01;
  options.sigma_model = 0.005;
  const auto named = orient(kModel, ground, options);
  ASSERT_TRUE(named);
  EXPECT_NE(absolute_text(*named).find("Control point 2 contradicts the others in Y"), std::string::npos)
      << absolute_text(*named);
  options.reject = true;
  const auto rejected = orient(kModel, ground, options);
  ASSERT_TRUE(rejected);
  EXPECT_TRUE(rejected->points[1].is_rejected);
  EXPECT_NEAR(rejected->points[1].misfit.y(), 1, 1e-3);
}

TEST_F(AbsoluteJob, CheckPointsTakeNoPart) {
  OrientAbsoluteOptions options;
  options.check = "5";
  const auto report = orient(kModel, kGround, options);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->variance.redundancy, 5);
  EXPECT_TRUE(report->points[4].is_check);
  options.check = "6";
  EXPECT_FALSE(orient(kModel, kGround, options));
}

TEST_F(AbsoluteJob, HeightsAlonePlanAloneAndTheModelsCovariance) {
  std::string ground = kGround;
  ground += "6 - - 7\n";
  ground.replace(ground.find("50.964912281"), 12, "-");
  const auto report = orient(kModel, ground);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->full, 4);
  EXPECT_EQ(report->plan, 1);
  EXPECT_TRUE(write_file(folder_ / "c.txt",
                         "point_1 axis_1 point_2 axis_2 covariance\n1 U 1 U 1e-4\n1 V 1 V 1e-4\n1 W 1 W 1e-4\n"
                         "2 U 2 U 1e-4\n1 U 2 U 0.5e-4\n"));
  OrientAbsoluteOptions options;
  options.model_covariance = folder_ / "c.txt";
  options.sigma_ground = 0.01;
  EXPECT_TRUE(orient(kModel, kGround, options));
  EXPECT_TRUE(write_file(folder_ / "c.txt", "point_1 axis_1 point_2 axis_2 covariance\n1 Q 1 U 1e-4\n"));
  EXPECT_FALSE(orient(kModel, kGround, options));
}

TEST_F(AbsoluteJob, PlaneSimilarityWithItsInverse) {
  OrientAbsoluteOptions options;
  options.method = AbsoluteMethod::kPlane;
  const auto report =
      orient("point U V\na 0 0\nb 1 0\nc 0 1\n", "point X[m] Y[m]\na 10 20\nb 10 22\nc 8 20\n", options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(report->parameters[2].value, 2, 1e-9);
  EXPECT_NEAR(report->parameters[3].value, 90, 1e-9);
  EXPECT_NEAR(report->inverse_parameters[0].value, -10, 1e-9);
  EXPECT_NEAR(report->inverse_parameters[1].value, 5, 1e-9);
}

TEST_F(AbsoluteJob, AWrongCheckPointOfAPlaneSimilarityIsNamed) {
  OrientAbsoluteOptions options;
  options.method = AbsoluteMethod::kPlane;
  options.sigma_ground = 0.01;
  options.sigma_model = 0.005;
  options.check = "d";
  const std::string model = "point U V\na 0 0\nb 1 0\nc 0 1\nd 1 1\n",
                    ground = "point X[m] Y[m]\na 10 20\nb 10 22\nc 8 20\n";
  const auto named = [&](const std::string& check) {
    const auto report = orient(model, ground + check, options);
    EXPECT_TRUE(report) << report.error().message;
    // the point lies beyond the others: more uncertain than 1 cm of the ground and 1 cm of the model, scaled
    EXPECT_GT(report->points[3].sigma.x(), 0.0141);
    return std::ranges::count(report->findings, FindingCode::kCheckPoint, &Finding::code);
  };
  EXPECT_EQ(named("d 8.01 22.01\n"), 0);
  EXPECT_EQ(named("d 8.3 22\n"), 1);
}

TEST_F(AbsoluteJob, BadTablesAreRefused) {
  EXPECT_FALSE(orient("point U V\n1 0 0\n", kGround));
  EXPECT_FALSE(orient("point U V W\n1 0 0 0\n1 0 0 0\n", kGround));
  EXPECT_FALSE(orient(kModel, "point X Y Z\n9 0 0 0\n"));
  EXPECT_FALSE(orient(kModel, "point X Y Z\n1 0 - 0\n"));
  EXPECT_FALSE(orient(kModel, "point X Y Z\n1 0 0 0\n2 3 4 5\n"));
  EXPECT_FALSE(orient_absolutely(folder_ / "none.txt", folder_ / "none.txt", {}));
}

}  // namespace
}  // namespace collinea
