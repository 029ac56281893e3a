// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blocks of independent models with known truth, for tests.

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "collinea/geometry/rotation.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/math/random.h"
#include "collinea/models/stereo_model.h"

namespace collinea::testing {

inline Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

struct TestModelsOptions {
  int strips = 2, models = 4;  ///< models of a strip
  double base_m = 600, height_m = 1000, relief_m = 60;
  double sigma = 0;            ///< noise of u and v, in ground units; of w twice that
  double control_sigma_m = 0;  ///< 0: fixed
  bool level = false;          ///< models turned about their w axis and little else
  bool correlated = false;     ///< a full covariance for each model
  bool centres = true;         ///< projection centres are points of the models
  int singles = 1;             ///< points of each model that no other shows
  std::uint64_t seed = 1;
};

struct TestModels {
  std::vector<StereoModel> models;
  std::vector<SurveyedPoint> control;  ///< the corners full, heights at both ends of every strip, one check point
  std::map<std::string, Eigen::Vector3d> truth;
  std::vector<Similarity3> ground_from_model;
};

inline std::string ground_name(int row, int column) { return "P" + std::to_string(100 * row + column); }

// Points in rows across the strips (three of a strip, those between strips in both) and columns below the centres.
inline void make_ground(TestModels& made, const TestModelsOptions& o, Random& random) {
  for (int row = 0; row <= 2 * o.strips; ++row)
    for (int column = 0; column <= o.models; ++column)
      made.truth[ground_name(row, column)] =
          Eigen::Vector3d(column * o.base_m, row * o.base_m, 200 + o.relief_m * random.normal()) +
          Eigen::Vector3d(0.05 * o.base_m * random.normal(), 0.05 * o.base_m * random.normal(), 0);
  for (int strip = 0; strip < o.strips; ++strip)
    for (int column = 0; column <= o.models; ++column)
      made.truth["O" + std::to_string(100 * strip + column)] =
          Eigen::Vector3d(column * o.base_m, (2 * strip + 1) * o.base_m, 200 + o.height_m) + 5 * normal3(random);
}

inline Eigen::MatrixXd drawn_covariance(const TestModelsOptions& o, Eigen::Index points, double scale, Random& random) {
  Eigen::VectorXd sigma(3 * points);
  for (Eigen::Index i = 0; i < 3 * points; ++i) sigma[i] = (i % 3 == 2 ? 2 : 1) * scale * (o.sigma > 0 ? o.sigma : 1);
  Eigen::MatrixXd covariance = sigma.cwiseAbs2().asDiagonal();
  if (!o.correlated) return covariance;
  for (int common = 0; common < 3; ++common) {  // what the points of a model have in common
    Eigen::VectorXd factor(3 * points);
    for (Eigen::Index i = 0; i < 3 * points; ++i) factor[i] = 0.7 * sigma[i] * random.normal();
    covariance += factor * factor.transpose();
  }
  return covariance;
}

inline TestModels test_models(const TestModelsOptions& o = {}) {
  Random random(o.seed), noise(o.seed, 7);
  TestModels made;
  make_ground(made, o, random);
  for (int strip = 0; strip < o.strips; ++strip)
    for (int k = 0; k < o.models; ++k) {
      StereoModel model{std::to_string(100 * strip + k), {}, {}};
      std::vector<std::string> names;
      for (int row = 2 * strip; row <= 2 * strip + 2; ++row)
        for (int column = k; column <= k + 1; ++column) names.push_back(ground_name(row, column));
      for (int column = k; o.centres && column <= k + 1; ++column)
        names.push_back("O" + std::to_string(100 * strip + column));
      for (int single = 0; single < o.singles; ++single) {
        names.push_back("S" + model.name + "_" + std::to_string(single));
        made.truth[names.back()] = {(k + random.uniform()) * o.base_m, (2 * strip + 2 * random.uniform()) * o.base_m,
                                    200 + o.relief_m * random.normal()};
      }
      const Eigen::Vector3d turn =
          o.level ? Eigen::Vector3d(0.03 * random.normal(), 0.03 * random.normal(), random.uniform(-3, 3))
                  : 2 * normal3(random);
      const Similarity3 ground_from_model{800 + 100 * random.normal(), rotation_by(turn), 1e3 * normal3(random)};
      const Similarity3 model_from_ground = inverse(ground_from_model);
      made.ground_from_model.push_back(ground_from_model);
      const auto n = static_cast<Eigen::Index>(names.size());
      const Eigen::MatrixXd covariance = drawn_covariance(o, n, model_from_ground.scale, random);
      Eigen::VectorXd error(3 * n);
      for (Eigen::Index i = 0; i < 3 * n; ++i) error[i] = noise.normal();
      error = (covariance.llt().matrixL() * error).eval();
      if (!(o.sigma > 0)) error.setZero();
      for (Eigen::Index i = 0; i < n; ++i) {
        const std::string& name = names[static_cast<std::size_t>(i)];
        model.points.push_back({name, model_from_ground * made.truth.at(name) + error.segment<3>(3 * i),
                                covariance.block<3, 3>(3 * i, 3 * i)});
      }
      if (o.correlated) model.covariance = covariance;
      made.models.push_back(std::move(model));
    }
  const double infinite = std::numeric_limits<double>::infinity();
  const auto survey = [&](int row, int column, bool plan, bool is_check) {
    SurveyedPoint point{ground_name(row, column), {}, Eigen::Vector3d::Constant(o.control_sigma_m), is_check};
    point.position = made.truth.at(point.name) + o.control_sigma_m * normal3(noise);
    if (!plan) point.sigma.head<2>().setConstant(infinite);
    made.control.push_back(point);
  };
  for (const int row : {0, 2 * o.strips})
    for (const int column : {0, o.models}) survey(row, column, true, false);
  for (int row = 1; row < 2 * o.strips; ++row)
    for (const int column : {0, o.models}) survey(row, column, false, false);
  survey(1, 1, true, true);
  return made;
}

}  // namespace collinea::testing
