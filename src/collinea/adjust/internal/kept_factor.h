// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/adjust/internal/problem.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// Solves the reduced normal equations of a block again and again: by Cholesky's factor or, while an older factor is
/// still like the matrix, by conjugate gradients with that factor as preconditioner. From step to step, and from
/// adjustment to adjustment of the same images, only weights and a few rays change; the work of a factor grows with the
/// 1.5th power of the number of images, that of an iteration hardly faster than the number itself.
class KeptFactor {
 public:
  /// From here on the unknowns are those of `problem`. A factor from before serves as preconditioner when it has all of
  /// them.
  void meet(const Problem& problem);
  /// Solves matrix x = x in place. False when the matrix is found not to be positive definite, or the run
  /// was stopped. `pattern`: of the matrix.
  [[nodiscard]] bool solve(const TileMatrix& matrix, const TilePattern& pattern, double* x, const Run& run);
  /// Factors the matrix; the factor is handed out and no longer kept. `failed_row`: see TileCholesky.
  [[nodiscard]] std::optional<TileCholesky> take(const TileMatrix& matrix, const TilePattern& pattern, const Run& run,
                                                 double least_pivot, int& failed_row);

 private:
  struct Unknowns {
    std::vector<ImageId> images;
    std::vector<std::array<std::uint32_t, 3>> others;  // of the global parameters: what it is, whose, which of its
  };
  [[nodiscard]] bool refresh(const TileMatrix& matrix, const TilePattern& pattern, const Run& run, double least_pivot);
  [[nodiscard]] bool solve_by_old(const TileMatrix& matrix, double* x) const;
  void precondition(const std::vector<double>& r, std::vector<double>& z) const;

  Unknowns unknowns_, factored_;
  std::optional<TileCholesky> factor_;
  bool same_structure_ = false;  // the factor was made for the matrix of this problem
  std::vector<int> row_;         // of each unknown in the factor; empty: the same
  bool complete_ = false;        // the factor was found to its end
  bool usable_ = false;          // as it is, or as preconditioner
};

}  // namespace collinea::bundle
