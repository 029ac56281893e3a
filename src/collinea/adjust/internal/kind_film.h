// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/internal/kind_prior.h"

namespace collinea::bundle {

/// The local deformation of a scan of film as it is expected before the adjustment (camera/film_prior.h): its functions
/// have a normal distribution, whose covariance C = L L' is full. With L^-1 times them these are observations of unit
/// weight, one for each function of the column and of the row.
struct FilmDeformation : Prior<FilmDeformation> {
  struct Item {
    std::size_t camera;     ///< in Problem::cameras
    Eigen::Index number;    ///< of the function
    std::size_t is_of_row;  ///< 0: of the column, 1: of the row
  };

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (std::size_t camera = 0; camera < problem.cameras.size(); ++camera)
      for (Eigen::Index k = 0; k < problem.cameras[camera].film_whitening.rows(); ++k)
        for (const std::size_t is_of_row : {0u, 1u}) visit(Item{camera, k, is_of_row});
  }
  static Vector residual(const Problem& problem, const State& state, const Item& item) {
    const ProblemCamera& camera = problem.cameras[item.camera];
    double sum = 0;
    for (Eigen::Index i = 0; i <= item.number; ++i) {
      const std::size_t param = Camera::kParams + 2 * std::size_t(i) + item.is_of_row;
      sum += camera.film_whitening(item.number, i) * (camera.given[param] - state.cameras[item.camera][param]);
    }
    return Vector(sum);
  }
  static Vector inverse_sigma(const Problem&, const Item&) { return Vector(1); }
  static Row row(const Problem& problem, const State&, const Item& item, int) {
    const ProblemCamera& camera = problem.cameras[item.camera];
    const int first = 6 * problem.poses + camera.first_global + static_cast<int>(camera.first_film_unknown());
    Row row;
    for (Eigen::Index i = 0; i <= item.number; ++i)
      row.push_back(
          {first + static_cast<int>(2 * i) + static_cast<int>(item.is_of_row), camera.film_whitening(item.number, i)});
    return row;
  }
};

}  // namespace collinea::bundle
