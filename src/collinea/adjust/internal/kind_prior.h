// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/internal/observation.h"

namespace collinea::bundle {

/// What priors have in common: each is of one unknown, so that a step keeps exactly what the linear model predicts, and
/// they are not tested.
template <class Kind>
struct Prior : ObservationKind<Kind, 1> {
  using Vector = typename ObservationKind<Kind, 1>::Vector;
  static constexpr bool kIsTested = false;
  static constexpr bool kIsOfPosition = false;

  static Vector predicted(const Problem& problem, const State&, const State& next, const std::vector<double>&,
                          const auto& item) {
    return Kind::whitened(problem, next, item);
  }
};

/// The value that a free parameter of a camera had before the adjustment, with a standard deviation that keeps it from
/// running away where the geometry is weak (calibration_named()).
struct CameraPrior : Prior<CameraPrior> {
  struct Item {
    std::size_t camera, number;  ///< in Problem::cameras, and of ProblemCamera::free
  };

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (std::size_t camera = 0; camera < problem.cameras.size(); ++camera)
      for (std::size_t k = 0; k < problem.cameras[camera].free.size(); ++k) visit(Item{camera, k});
  }
  static Vector residual(const Problem& problem, const State& state, const Item& item) {
    const int param = param_of(problem, item);
    return Vector(problem.cameras[item.camera].given[param] - state.cameras[item.camera][param]);
  }
  static Vector inverse_sigma(const Problem& problem, const Item& item) {
    return Vector(problem.cameras[item.camera].inverse_sigma[param_of(problem, item)]);
  }
  static Row row(const Problem& problem, const State&, const Item& item, int) {
    return {{6 * problem.poses + problem.cameras[item.camera].first_global + static_cast<int>(item.number), 1}};
  }

 private:
  static std::size_t param_of(const Problem& problem, const Item& item) {
    return static_cast<std::size_t>(problem.cameras[item.camera].free[item.number]);
  }
};

/// The given value of an unknown beside images, cameras and points: lever arm, shift, drift, boresight, time offset.
struct AuxiliaryPrior : Prior<AuxiliaryPrior> {
  using Item = std::size_t;  ///< in Problem::auxiliaries

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (Item i = 0; i < problem.auxiliaries.size(); ++i) visit(i);
  }
  static Vector residual(const Problem& problem, const State& state, Item i) {
    return Vector(problem.auxiliaries[i].given - state.auxiliaries[i]);
  }
  static Vector inverse_sigma(const Problem& problem, Item i) { return Vector(problem.auxiliaries[i].inverse_sigma); }
  static Row row(const Problem& problem, const State&, Item i, int) {
    return {{6 * problem.poses + problem.first_auxiliary + static_cast<int>(i), 1}};
  }
};

}  // namespace collinea::bundle
