// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/model_block.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/math/fisher.h"
#include "collinea/models/internal/local_normals.h"
#include "collinea/models/test_models.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::test_models;
using testing::TestModels;
using testing::TestModelsOptions;

const JoinedPoint& point_of(const JoinedBlock& block, const std::string& name) {
  for (const JoinedPoint& point : block.points)
    if (point.name == name) return point;
  throw std::runtime_error(name);
}

JoinedBlock joined(const TestModels& made, const JoinOptions& options = {}) {
  auto block = join_models(made.models, made.control, options, {});
  if (!block) throw std::runtime_error(block.error().message);
  return *std::move(block);
}

TEST(ModelBlock, ExactModelsGiveTheTruth) {
  for (const bool level : {true, false}) {
    const TestModels made = test_models({.level = level});
    const JoinedBlock block = joined(made);
    EXPECT_EQ(block.points.size(), made.truth.size());
    for (const JoinedPoint& point : block.points)
      EXPECT_LT((point.position - made.truth.at(point.name)).norm(), 1e-6) << point.name;
    for (std::size_t m = 0; m < made.models.size(); ++m) {
      ASSERT_TRUE(block.models[m]);
      EXPECT_NEAR(block.models[m]->ground_from_model.scale / made.ground_from_model[m].scale, 1, 1e-10);
      EXPECT_LT((block.models[m]->ground_from_model.translation - made.ground_from_model[m].translation).norm(), 1e-5);
    }
    EXPECT_LT(block.squares, 1e-9);
  }
}

// Mussio 4.3.7: 7 unknowns a model, 3 a point; 3 observations a model point, 2 of control in plan, 1 in height. Here
// the control is weighted, so that it is observed.
TEST(ModelBlock, CountsAreThoseOfMussio437) {
  const TestModels made = test_models({.sigma = 0.05, .control_sigma_m = 0.02});
  const JoinedBlock block = joined(made);
  const long models = 8, points = 3 * 5 + 2 * 5 + 2 * 5 + 8;  // two strips: five rows of five, ten centres, singles
  EXPECT_EQ(block.unknowns, 7 * models + 3 * points);
  EXPECT_EQ(block.observations, 3 * models * (6 + 2 + 1) + 4 * 3 + 6);
  double numbers = 0;
  for (const auto& model : block.models) numbers += model->redundancy;
  for (const JoinedControl& one : block.control)
    for (const CoordinateTest& test : one.tests) numbers += test.redundancy;
  EXPECT_NEAR(numbers, double(block.redundancy()), 1e-6);
}

// Chi-squared of estimate minus truth, the chance of v'Pv, and tests that exceed their limit.
struct Truths {
  double sum = 0, within = 0, squares = 0, parameters = 0, beyond = 0, tested = 0, checks = 0;
};

Truths truths(TestModelsOptions o, const std::vector<std::string>& names, int seeds) {
  Truths found;
  for (int seed = 1; seed <= seeds; ++seed) {
    o.seed = static_cast<std::uint64_t>(seed);
    const TestModels made = test_models(o);
    const JoinedBlock block = joined(made, {.false_alarm = 0.05});
    for (const std::string& name : names) {
      const JoinedPoint& point = point_of(block, name);
      const Vector3d error = point.position - made.truth.at(name);
      const double chi_squared = error.dot(point.covariance.inverse() * error);
      found.sum += chi_squared / 3 / double(names.size());
      found.within += (fisher_tail(chi_squared / 3, 3, INFINITY) > 0.05 ? 1.0 : 0.0) / double(names.size());
    }
    found.squares += block.squares / double(block.redundancy());
    const JoinedControl& check = block.control.back();
    found.checks += check.difference.cwiseQuotient(check.sigma).squaredNorm() / 3 / seeds;
    const JoinedModel& model = *block.models[1];
    const Similarity3& truth = made.ground_from_model[1];
    const OmegaPhiKappa angles = omega_phi_kappa((truth.rotation * Eigen::Quaterniond(0, 1, 0, 0)).conjugate());
    Eigen::Matrix<double, 7, 1> error;
    error << model.ground_from_model.translation - truth.translation,
        std::remainder(model.omega_rad - angles.omega_deg * M_PI / 180, 2 * M_PI),
        std::remainder(model.phi_rad - angles.phi_deg * M_PI / 180, 2 * M_PI),
        std::remainder(model.kappa_rad - angles.kappa_deg * M_PI / 180, 2 * M_PI),
        model.ground_from_model.scale - truth.scale;
    const Eigen::Matrix<double, 7, 1> sigma = model.covariance.diagonal().cwiseSqrt();
    const Eigen::Matrix<double, 7, 7> correlation =
        sigma.cwiseInverse().asDiagonal() * model.covariance * sigma.cwiseInverse().asDiagonal();
    const Eigen::Matrix<double, 7, 1> reduced = error.cwiseQuotient(sigma);
    found.parameters += reduced.dot(correlation.fullPivLu().solve(reduced)) / 7;
    for (const auto& one : block.models)
      for (const auto& tests : one->tests)
        for (const CoordinateTest& test : tests)
          if (test.redundancy > 1e-3) {
            ++found.tested;
            found.beyond += std::abs(test.w) > block.limit;
          }
  }
  found.sum /= seeds;
  found.within /= seeds;
  found.squares /= seeds;
  found.parameters /= seeds;
  return found;
}

void expect_true(const Truths& found) {
  EXPECT_NEAR(found.sum, 1, 0.1);
  EXPECT_NEAR(found.within, 0.95, 0.02);
  EXPECT_NEAR(found.squares, 1, 0.05);  // four of its standard deviations
  EXPECT_NEAR(found.parameters, 1, 0.1);
  EXPECT_NEAR(found.checks, 1, 0.2);  // four standard deviations of a mean over 300
  EXPECT_NEAR(found.beyond / found.tested, 0.05, 0.01);
}

TEST(ModelBlock, CovariancesTellTheTruthOfIndependentPoints) {
  expect_true(truths({.sigma = 0.05, .control_sigma_m = 0.03, .level = true}, {"P1", "P202", "O1", "S2_0"}, 300));
}

TEST(ModelBlock, CovariancesTellTheTruthOfCorrelatedModels) {
  expect_true(truths({.sigma = 0.05, .control_sigma_m = 0.03, .level = true, .correlated = true},
                     {"P1", "P202", "O1", "S2_0"}, 300));
}

TEST(ModelBlock, FixedControlStays) {
  const TestModels made = test_models({.sigma = 0.05});
  const JoinedBlock block = joined(made);
  const JoinedPoint& corner = point_of(block, "P0");
  EXPECT_LT((corner.position - made.truth.at("P0")).norm(), 1e-9);
  EXPECT_EQ(corner.covariance.norm(), 0);
  EXPECT_LT(std::abs(point_of(block, "P100").position.z() - made.truth.at("P100").z()), 1e-9);
  EXPECT_GT(point_of(block, "P100").covariance(0, 0), 0);
}

// A frame that was chosen (centre in the origin, unit base) has a singular covariance. Whatever was chosen, the block
// is the same.
TEST(ModelBlock, TheFrameOfAModelDoesNotMatter) {
  TestModels made = test_models({.sigma = 0.005, .control_sigma_m = 0.02, .level = true, .correlated = true});
  const JoinedBlock before = joined(made);
  for (StereoModel& model : made.models) {
    // Points 0 and 1 and the w of point 2 fix the frame; what they had is removed from all others, to first order.
    const auto n = static_cast<Eigen::Index>(3 * model.points.size());
    Eigen::MatrixXd motion(n, 7), fixed = Eigen::MatrixXd::Zero(7, n);
    for (std::size_t i = 0; i < model.points.size(); ++i)
      motion.middleRows<3>(static_cast<Eigen::Index>(3 * i)) << model.points[i].position,
          -skew(model.points[i].position), Eigen::Matrix3d::Identity();
    for (int k = 0; k < 7; ++k) fixed(k, k < 6 ? k : 8) = 1;
    const Eigen::MatrixXd to = Eigen::MatrixXd::Identity(n, n) - motion * (fixed * motion).inverse() * fixed;
    model.covariance = (to * model.covariance * to.transpose()).eval();
    for (const Eigen::Index k : {0, 1, 2, 3, 4, 5, 8}) {
      model.covariance.row(k).setZero();
      model.covariance.col(k).setZero();
    }
  }
  const JoinedBlock after = joined(made);
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    EXPECT_LT((after.points[i].position - before.points[i].position).norm(), 2e-5);  // 5 mm of noise: second order
    EXPECT_LT((after.points[i].covariance - before.points[i].covariance).norm(),
              1e-3 * before.points[i].covariance.norm() + 1e-12);
  }
  EXPECT_NEAR(after.squares, before.squares, 1e-3 * before.squares);
}

TEST(ModelBlock, UnknownSigmasAreScaledBySigma0) {
  TestModels made = test_models({.sigma = 0.05, .control_sigma_m = 0.05, .level = true});
  const JoinedBlock truth = joined(made);
  for (StereoModel& model : made.models)
    for (NamedPoint& point : model.points) point.covariance *= 4;
  for (SurveyedPoint& point : made.control) point.sigma *= 2;
  const JoinedBlock block = joined(made, {.sigmas_known = false});
  EXPECT_NEAR(block.sigma0, truth.sigma0 / 2, 1e-9);
  EXPECT_NEAR(std::sqrt(point_of(block, "P1").covariance(0, 0) / point_of(truth, "P1").covariance(0, 0)), truth.sigma0,
              1e-6);
}

// The chain of so many models bends by more than can be linear.
TEST(ModelBlock, LongStripsOfWeakModelsAreJoined) {
  const TestModels made =
      test_models({.strips = 6, .models = 25, .sigma = 0.5, .control_sigma_m = 0.02, .level = true});
  const JoinedBlock block = joined(made);
  EXPECT_NEAR(block.sigma0, 1, 0.1);
}

TEST(ModelBlock, AGrossErrorHasTheLargestTest) {
  TestModels made = test_models({.sigma = 0.05, .control_sigma_m = 0.03, .level = true});
  made.models[2].points[1].position.z() += 2.0 / made.ground_from_model[2].scale;
  const JoinedBlock block = joined(made);
  EXPECT_LT(block.chance, 1e-6);
  double worst = 0;
  std::size_t where = 0, which = 0;
  for (std::size_t m = 0; m < block.models.size(); ++m)
    for (std::size_t i = 0; i < made.models[m].points.size(); ++i)
      for (const CoordinateTest& test : block.models[m]->tests[i])
        if (std::abs(test.w) > worst) worst = std::abs(test.w), where = m, which = i;
  EXPECT_EQ(where, 2);
  EXPECT_EQ(which, 1);
  EXPECT_GT(worst, block.limit);
}

TEST(ModelBlock, CheckPointsAreOnlyCompared) {
  TestModels made = test_models({.sigma = 0.05, .control_sigma_m = 0.03, .level = true});
  const JoinedBlock before = joined(made);
  made.control.back().position.x() += 5;
  const JoinedBlock after = joined(made);
  EXPECT_NEAR(before.squares, after.squares, 1e-6);
  EXPECT_NEAR(after.control.back().difference.x() - before.control.back().difference.x(), 5, 1e-9);
  EXPECT_GT(after.control.back().sigma.x(), 0.03);
}

TEST(ModelBlock, WithoutControlTheFirstModelIsTheFrame) {
  TestModels made = test_models({.sigma = 0.05});
  made.control.clear();
  const JoinedBlock block = joined(made);
  EXPECT_FALSE(block.chain.on_ground);
  const Similarity3& frame = block.models[block.chain.reference]->ground_from_model;
  EXPECT_LT(frame.translation.norm() + std::abs(frame.scale - 1), 1e-12);
  EXPECT_GT(block.redundancy(), 0);
}

TEST(ModelBlock, DegenerateBlocksAreNamed) {
  const auto error_of = [](const TestModels& made) {
    const auto block = join_models(made.models, made.control, {}, {});
    return block ? std::string() : block.error().message;
  };
  EXPECT_NE(error_of({}).find("no model"), std::string::npos);
  TestModels made = test_models({.sigma = 0.05});
  made.control.resize(1);
  EXPECT_NE(error_of(made).find("fixes 3 of the 7"), std::string::npos);
  made = test_models({.strips = 1, .models = 1});
  made.control.clear();
  EXPECT_NE(error_of(made).find("single model"), std::string::npos);
  made = test_models({.strips = 1, .models = 2, .centres = false});
  made.control.clear();
  made.models[1].points.erase(made.models[1].points.begin());
  EXPECT_NE(error_of(made).find("no two models"), std::string::npos);
  made = test_models({.sigma = 0.05});
  made.models[0].points.push_back(made.models[0].points[0]);
  EXPECT_NE(error_of(made).find("twice"), std::string::npos);
  made = test_models({.sigma = 0.05});
  made.models[3].points[2].position.x() = NAN;
  EXPECT_NE(error_of(made).find("model 3"), std::string::npos);
  made = test_models({.sigma = 0.05});
  made.models[3].points[2].covariance(0, 0) = -1;
  EXPECT_NE(error_of(made).find("model 3"), std::string::npos);
}

// A model that hangs by two points, one by none and two that hang together apart from all others.
TEST(ModelBlock, ModelsThatHangLooselyAreLeftOut) {
  TestModels made = test_models({.strips = 1, .models = 6, .sigma = 0.05, .centres = false});
  const auto rename = [&](std::size_t m, std::size_t from, const std::string& suffix) {
    for (std::size_t i = from; i < made.models[m].points.size(); ++i) made.models[m].points[i].name += suffix;
  };
  // Columns 4 and 5 of models 4 and 5 (points 1, 3, 5 are the right ones).
  for (StereoModel& model : made.models)
    for (NamedPoint& point : model.points)
      if (model.name == "5" && point.name != "P5" && point.name != "P105") point.name += "x";
  rename(0, 0, "y");
  made.control.clear();
  for (const auto& [row, column] : {std::pair(0, 1), {2, 1}, {0, 4}, {2, 5}}) {
    const std::string name = testing::ground_name(row, column);
    made.control.push_back({name, made.truth.at(name), Vector3d::Constant(0.02), false});
  }
  const JoinedBlock block = joined(made);
  ASSERT_EQ(block.chain.left_out.size(), 2);
  EXPECT_FALSE(block.models[0]);
  EXPECT_FALSE(block.models[5]);
  for (const LeftOutModel& one : block.chain.left_out)
    EXPECT_EQ(one.reason, one.model == 0 ? LeftOutReason::kNoPoint : LeftOutReason::kTooFew);
}

// Derivatives of model coordinates by the seven increments and by ground coordinates.
TEST(LocalNormals, DerivativesAreThoseOfTheFormula) {
  const TestModels made = test_models();
  const StereoModel& model = made.models[1];
  ModelState state{inverse(made.ground_from_model[1]), {0.3, -0.2, 0.7}};
  std::vector<Vector3d> ground;
  for (const NamedPoint& point : model.points) ground.push_back(made.truth.at(point.name));
  std::vector<bool> shared(ground.size(), true);
  shared[2] = false;
  const auto at = local_normals(model, state, ground, shared, false);
  ASSERT_TRUE(at);
  const double h = 1e-6;
  for (int k = 0; k < 7; ++k) {
    Eigen::Matrix<double, 7, 1> by = Eigen::Matrix<double, 7, 1>::Zero();
    by[k] = h;
    ModelState more = state, less = state;
    more.step(by);
    less.step(-by);
    for (std::size_t i = 0; i < ground.size(); ++i) {
      const Vector3d numeric = (more.model_from_ground * ground[i] - less.model_from_ground * ground[i]) / (2 * h);
      EXPECT_LT((numeric - at->own.block<3, 1>(static_cast<Eigen::Index>(3 * i), k)).norm(), 1e-7);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d by = h * Vector3d::Unit(axis);
    const Vector3d shared_one =
        (state.model_from_ground * (ground[3] + by) - state.model_from_ground * (ground[3] - by)) / (2 * h);
    EXPECT_LT((shared_one - at->shared.block<3, 1>(9, 6 + axis)).norm(), 1e-8);
    EXPECT_LT((shared_one - at->own.block<3, 1>(6, 7 + axis)).norm(), 1e-8);
  }
}

// Mussio D.8: an absolute orientation of five points, mu = 1.25, Rodrigues (0.2, -0.1, 0.3) without the factor 1/2,
// t = (100, 200, 50).
TEST(ModelBlock, AbsoluteOrientationOfMussioD8) {
  const Vector3d u[5] = {{0, 0, 0}, {10, 0, 1}, {0, 8, -1}, {10, 8, 2}, {5, 4, 3}};
  const Vector3d x[5] = {{100, 200, 50},
                         {110.657894737, 193.355263158, 50.263157895},
                         {104.561403509, 207.346491228, 44.824561404},
                         {115.921052632, 201.447368421, 47.368421053},
                         {108.662280702, 201.469298246, 50.964912281}};
  StereoModel model{"1", {}, {}};
  std::vector<SurveyedPoint> control;
  for (int i = 0; i < 5; ++i) {
    model.points.push_back({std::to_string(i), u[i], Eigen::Matrix3d::Identity()});
    control.push_back({std::to_string(i), x[i], Vector3d::Zero(), false});
  }
  const auto block = join_models({model}, control, {}, {});
  ASSERT_TRUE(block);
  EXPECT_NEAR(block->models[0]->ground_from_model.scale, 1.25, 1e-9);
  EXPECT_LT((block->models[0]->ground_from_model.translation - Vector3d(100, 200, 50)).norm(), 1e-8);
  EXPECT_LT(block->squares, 1e-15);
  EXPECT_EQ(block->redundancy(), 8);
}

// Mussio D.8 (4.3.7): 30 models in 3 strips with 60 points: 7 m + 3 n = 390 = 13 m unknowns.
TEST(ModelBlock, UnknownsOfMussioD8) {
  constexpr int kStrips = 3, kModels = 10, kColumns = 15;
  std::map<std::string, Vector3d> ground;
  Random random(1);
  for (int row = 0; row <= kStrips; ++row)
    for (int column = 0; column < kColumns; ++column)
      ground[testing::ground_name(row, column)] = Vector3d(300 * column, 900 * row, 100 * random.normal());
  std::vector<StereoModel> models;
  for (int strip = 0; strip < kStrips; ++strip)
    for (int first = 0; first < kModels; ++first) {
      StereoModel model{std::to_string(100 * strip + first), {}, {}};
      for (const int row : {strip, strip + 1})
        for (int column = first; column < first + kColumns - kModels + 1; ++column)
          model.points.push_back({testing::ground_name(row, column),
                                  ground.at(testing::ground_name(row, column)) / 1000,
                                  1e-8 * Eigen::Matrix3d::Identity()});
      models.push_back(model);
    }
  std::vector<SurveyedPoint> control;
  for (const int row : {0, kStrips})
    for (const int column : {0, kColumns - 1})
      control.push_back({testing::ground_name(row, column), ground.at(testing::ground_name(row, column)),
                         Vector3d::Constant(0.01), false});
  const auto block = join_models(models, control, {}, {});
  ASSERT_TRUE(block) << block.error().message;
  EXPECT_EQ(block->models.size(), 30u);
  EXPECT_EQ(block->points.size(), 60u);
  EXPECT_EQ(block->unknowns, 390);
}

}  // namespace
}  // namespace collinea
