// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/jobs/absolute.h"
#include "collinea/jobs/intersection.h"
#include "collinea/jobs/resection.h"

namespace collinea {
namespace {

// Exact measurements without stated standard deviations, as exercises have them: sigma0 is rounding, and tests by it
// would find contradictions among digits that nobody measured.
class ExactTables : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  TestFolder folder_;
};

bool says(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

// The tables of the manual; 11.538 is 150 / 13, rounded. Rounding of the cost is larger there than what a step gains.
TEST_F(ExactTables, AVerticalImageIsResected) {
  const auto ground = file(
      "g.txt", "point X[m] Y[m] Z[m]\n1 -900 1200 0\n2 1100 1200 0\n3 1100 -800 0\n4 -900 -800 0\n6 200 200 200\n");
  for (const char* x : {"11.538", "11.5384615384615385", "11.54"}) {
    ResectOneOptions options;
    options.photo.principal_distance = 150;
    const auto report = resect_from_tables(
        file("m.txt",
             std::string("image point x[mm] y[mm]\nA 1 -100 100\nA 2 100 100\nA 3 100 -100\nA 4 -100 -100\nA 6 ") + x +
                 " 0\n"),
        ground, options);
    ASSERT_TRUE(report) << x << ": " << report.error().message;
    // The middle of the four corners is a measurement of 0.0017 mm at most: some 0.02 m at 1500 m and 150 mm.
    EXPECT_NEAR(report->images[0].exterior[0].value, 100, 0.05) << x;
    EXPECT_NEAR(report->images[0].exterior[2].value, 1500, 0.05) << x;
  }
}

TEST_F(ExactTables, RaysThatMeetAreNotSaidToMiss) {
  const auto measurements = file("m.txt", "image point x[mm] y[mm]\nL 1 20 10\nR 1 -40 10\n");
  const auto orientation = file("o.txt",
                                "image X[m] Y[m] Z[m] omega[deg] phi[deg] kappa[deg]\nL 0 0 1500 0 0 0\n"
                                "R 600 0 1500 0 0 0\n");
  IntersectTableOptions options;
  options.photo.principal_distance = 150;
  const auto report = intersect_from_tables(measurements, orientation, options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LT((report->points[0].position - Eigen::Vector3d(200, 100, 0)).norm(), 1e-9);
  const std::string text = intersection_text(*report);
  EXPECT_FALSE(says(text, "nan") || says(text, "do not meet")) << text;
}

TEST_F(ExactTables, ControlThatFitsContradictsNothing) {
  const char* rows = "1 0 0 0\n2 10 0 1\n3 0 8 -1\n4 10 8 2\n5 3 5 4\n";
  const auto model = file("m.txt", std::string("point U[m] V[m] W[m]\n") + rows),
             ground = file("g.txt", std::string("point X[m] Y[m] Z[m]\n") + rows);
  for (const AbsoluteMethod method :
       {AbsoluteMethod::kLeastSquares, AbsoluteMethod::kUmeyama, AbsoluteMethod::kPlane}) {
    OrientAbsoluteOptions options;
    options.method = method;
    options.reject = true;
    const auto report = orient_absolutely(model, ground, options);
    ASSERT_TRUE(report) << report.error().message;
    const std::string text = absolute_text(*report);
    EXPECT_FALSE(says(text, "nan") || says(text, "Measure it again")) << text;
  }
}

}  // namespace
}  // namespace collinea
