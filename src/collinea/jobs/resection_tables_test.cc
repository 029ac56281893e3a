// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/resection.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
constexpr double kDegrees = 180 / M_PI;
const CardanAngles kAngles{0.1, -0.2, 0.6};
const Vector3d kCentre(20, -30, 900);

class ResectionTablesOut : public ::testing::Test {
 protected:
  // A photograph of 20 points with errors of 5 um, principal distance 150 mm.
  [[nodiscard]] Result<ResectionReport> resect(std::uint64_t seed, const ResectOneOptions& options) const {
    Random random(seed);
    const Eigen::Matrix3d r = rotation_matrix(kAngles);
    std::string measurements = "point x[mm] y[mm] sigma[mm]\n", ground = "point X Y Z\n";
    for (int i = 0; i < 20; ++i) {
      const bool is_plane = options.method == ResectionMethod::kPlane;
      const Vector3d point(random.uniform(-400, 400), random.uniform(-400, 400), is_plane ? 0 : random.uniform(0, 150));
      const Vector3d seen = r * (point - kCentre);
      const Vector2d xy = -150 * seen.head<2>() / seen.z() + 0.005 * Vector2d(random.normal(), random.normal());
      measurements += std::to_string(i) + " " + exact(xy.x()) + " " + exact(xy.y()) + " 0.005\n";
      ground += std::to_string(i) + " " + exact(point.x()) + " " + exact(point.y()) + " " + exact(point.z()) + "\n";
    }
    EXPECT_TRUE(write_file(folder_ / "m.txt", measurements));
    EXPECT_TRUE(write_file(folder_ / "g.txt", ground));
    return resect_from_tables(folder_ / "m.txt", folder_ / "g.txt", options);
  }
  TestFolder folder_;
};

double chi_squared(const VectorXd& error, const Eigen::MatrixXd& covariance) {
  const VectorXd unit = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * covariance * unit.asDiagonal();
  const VectorXd e = unit.asDiagonal() * error;
  return e.dot(scaled.ldlt().solve(e));
}

VectorXd errors_of(const std::vector<Estimate>& estimates, const std::vector<double>& truth) {
  VectorXd error(Eigen::Index(estimates.size()));
  for (std::size_t i = 0; i < estimates.size(); ++i) error[Eigen::Index(i)] = estimates[i].value - truth[i];
  return error;
}

// 300 seeds: the mean of chi-squared over its f degrees of freedom scatters by sqrt(2 / f / 300): four of them.
TEST_F(ResectionTablesOut, CovariancesOfPoseAndInteriorMatchTheRealErrors) {
  constexpr int kSeeds = 300;
  const std::vector<double> pose{kCentre.x(),
                                 kCentre.y(),
                                 kCentre.z(),
                                 kAngles.omega_rad * kDegrees,
                                 kAngles.phi_rad * kDegrees,
                                 kAngles.kappa_rad * kDegrees};
  std::vector<double> all = pose;
  all.insert(all.end(), {150, 150, 90, 0, 0});
  double of_pose = 0, of_all = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    ResectOneOptions options;
    options.method = ResectionMethod::kPlane;
    options.photo.principal_distance = 150;
    const auto plane = resect(seed, options);
    ASSERT_TRUE(plane);
    of_pose += chi_squared(errors_of(plane->images[0].exterior, pose), plane->images[0].covariance) / 6 / kSeeds;
    options.method = ResectionMethod::kDlt;
    const auto dlt = resect(seed, options);
    ASSERT_TRUE(dlt);
    std::vector<Estimate> both = dlt->images[0].exterior;
    both.insert(both.end(), dlt->images[0].interior.begin(), dlt->images[0].interior.end());
    of_all += chi_squared(errors_of(both, all), dlt->images[0].joint_covariance) / 11 / kSeeds;
  }
  EXPECT_NEAR(of_pose, 1, 4 * std::sqrt(2.0 / 6 / kSeeds));
  EXPECT_NEAR(of_all, 1, 4 * std::sqrt(2.0 / 11 / kSeeds));
}

const TextTable* table_of(const std::vector<NamedTable>& tables, const std::string& name) {
  const auto found = std::find_if(tables.begin(), tables.end(), [&](const NamedTable& t) { return t.name == name; });
  return found == tables.end() ? nullptr : &found->table;
}

std::vector<std::string> row_of(const TextTable& table, const std::string& parameter) {
  for (const auto& row : table.rows)
    if (row[0] == parameter) return row;
  ADD_FAILURE() << "no row " << parameter;
  return std::vector<std::string>(table.columns.size());
}

TEST_F(ResectionTablesOut, TheMatrixItsElementsAndTheirCorrelationsAreTables) {
  ResectOneOptions options;
  options.method = ResectionMethod::kDlt;
  const auto report = resect(1, options);
  ASSERT_TRUE(report) << report.error().message;
  const auto tables = resection_tables(*report);
  const TextTable *correlations = table_of(tables, "correlations.txt"), *interior = table_of(tables, "interior.txt"),
                  *elements = table_of(tables, "elements.txt"), *matrix = table_of(tables, "matrix.txt"),
                  *of_elements = table_of(tables, "element_correlations.txt");
  ASSERT_TRUE(correlations && interior && elements && matrix && of_elements);
  EXPECT_EQ(correlations->rows.size(), 11u);
  EXPECT_EQ(interior->rows.size(), 5u);
  EXPECT_EQ(elements->rows.size(), 11u);
  EXPECT_EQ(of_elements->columns.size(), 12u);
  EXPECT_EQ(of_elements->rows[10][11], "1.000000");
  EXPECT_EQ(matrix->rows.size(), 27u);
  // The same quantity has the same value and standard deviation wherever it stands.
  const auto same = [&](const std::string& a, const std::string& b, double sign) {
    const auto in_matrix = row_of(*matrix, a);
    for (const auto& e : report->images[0].exterior)
      if (e.name == b) {
        EXPECT_NEAR(*finite_number(in_matrix[1]), e.value, 1e-9 * std::abs(e.value));
        EXPECT_NEAR(*finite_number(in_matrix[2]), *e.sigma, 1e-4 * *e.sigma);
      }
    for (const auto& e : report->images[0].interior)
      if (e.name == b) {
        EXPECT_NEAR(*finite_number(in_matrix[1]), sign * e.value, 1e-9 * std::abs(e.value));
        EXPECT_NEAR(*finite_number(in_matrix[2]), *e.sigma, 1e-4 * *e.sigma);
      }
  };
  same("C_1", "X", 1);
  same("C_3", "Z", 1);
  same("K_11", "c_x", -1);
  same("K_13", "x0", 1);
  EXPECT_EQ(row_of(*matrix, "K_33")[2], "0");
  EXPECT_EQ(row_of(*matrix, "K_21")[2], "0");
}

TEST_F(ResectionTablesOut, APlaneWithoutPrincipalDistanceHasItsEightElements) {
  ResectOneOptions options;
  options.method = ResectionMethod::kPlane;
  const auto report = resect(1, options);
  ASSERT_TRUE(report) << report.error().message;
  const auto tables = resection_tables(*report);
  const TextTable *elements = table_of(tables, "elements.txt"),
                  *of_elements = table_of(tables, "element_correlations.txt");
  ASSERT_TRUE(elements && of_elements);
  EXPECT_EQ(elements->rows.size(), 8u);
  EXPECT_EQ(of_elements->rows.size(), 8u);
  EXPECT_GT(*finite_number(elements->rows[0][2]), 0);
  EXPECT_FALSE(table_of(tables, "correlations.txt"));
  EXPECT_FALSE(table_of(tables, "matrix.txt"));
}

}  // namespace
}  // namespace collinea
