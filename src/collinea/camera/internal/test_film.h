// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "collinea/camera/film_fit.h"
#include "collinea/math/random.h"

namespace collinea::test {

inline constexpr FilmModel kModels[] = {FilmModel::kRigid, FilmModel::kSimilarity, FilmModel::kTwoScales,
                                        FilmModel::kAffine, FilmModel::kProjective};

inline const Eigen::Vector2d kEight[] = {{-106, -106}, {106, 106}, {-106, 106}, {106, -106},
                                         {-112, 0},    {112, 0},   {0, 112},    {0, -112}};

inline FilmTransformation example(FilmModel model) {
  FilmTransformation t;
  t.model = model;
  t.scale_px_per_mm = 80;
  Eigen::VectorXd all(8);
  all << 10254.3, 10378.1, 0.03, 80.01, 79.98, 3e-4, 2e-6, -3e-6;
  if (model == FilmModel::kSimilarity) all[4] = all[3];
  t.parameters = all.head(parameter_count(model));
  t.covariance = Eigen::MatrixXd::Zero(t.parameters.size(), t.parameters.size());
  return t;
}

inline std::vector<FilmMark> marks_of(const FilmTransformation& t, double sigma_px, Random& random,
                                      std::size_t count = 8) {
  std::vector<FilmMark> marks;
  for (std::size_t i = 0; i < count; ++i)
    marks.push_back({.name = std::to_string(i + 1),
                     .film_mm = kEight[i],
                     .pixel = t.pixel_of(kEight[i]) + sigma_px * Eigen::Vector2d(random.normal(), random.normal()),
                     .covariance = (sigma_px > 0 ? sigma_px * sigma_px : 1) * Eigen::Matrix2d::Identity()});
  return marks;
}

}  // namespace collinea::test
