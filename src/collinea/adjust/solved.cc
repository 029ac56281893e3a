// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/solved.h"

#include <cmath>
#include <utility>

#include "collinea/adjust/internal/normals.h"

namespace collinea {
Solved::Solved(const Block& block, std::unique_ptr<const bundle::Problem> problem, bundle::State state,
               std::shared_ptr<bundle::KeptFactor> kept, std::unique_ptr<bundle::Normals> normals, Adjusted estimate)
    : block_(&block),
      problem_(std::move(problem)),
      state_(std::move(state)),
      kept_(std::move(kept)),
      normals_(std::move(normals)),
      estimate_(std::move(estimate)) {}

Solved::~Solved() = default;
Solved::Solved(Solved&&) noexcept = default;
Solved& Solved::operator=(Solved&&) noexcept = default;

Solved::Factored Solved::factor(const Run& run) {
  Factored result;
  normals_->accumulate(state_, 0, run, bundle::kExactDatum);
  result.factor = normals_->factor(run, bundle::kLeastPivot, result.failed_row);
  return result;
}

Solved::Factored Solved::factor_stiffened(double part, const Run& run) {
  Factored result;
  const double cost = normals_->accumulate(state_, part, run, bundle::kExactDatum);
  result.factor = normals_->factor(run, 0, result.failed_row);
  if (!std::isfinite(cost)) result.factor.reset();
  return result;
}

const std::vector<double>& Solved::diagonal() const { return normals_->diagonal(); }

}  // namespace collinea
