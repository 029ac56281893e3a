// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "blocks.h"
#include "collinea/quality/variance_components.h"
#include "collinea/report/value_words.h"
#include "rows.h"

namespace collinea::bench {

// As large as the images' share of it: what is drowned in the errors of what checks it cannot be told.
constexpr double kControlSigma_m = 0.03;

// The sigmas of half of the groups are given three times too large, the others three times too small; the next block
// has it the other way round.
Rows variance_components(const Effort& effort, const Run& run) {
  std::array<double, kObservationGroups> sum{}, squares{}, blocks{}, reported{};
  int failed = 0, rounds = 0;
  for (int i = 0; i < effort.gross_error_blocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(3000 + i);
    Block exact = exact_block(Layout::kCrossStrips, {.points = 300, .control = 30}, seed);
    for (auto& [id, control] : exact.control) control.sigma_m.setConstant(kControlSigma_m);
    SigmaFactors wrong;
    for (std::size_t g = 0; g < kObservationGroups; ++g) wrong[g] = (g + static_cast<std::size_t>(i)) % 2 ? 3 : 1.0 / 3;
    const Measured made = measured(exact, seed);
    const Block stated_wrongly = with_sigmas(made.block, wrong);
    const auto found =
        estimate_variance_components(stated_wrongly, made.scope, exact_options(Calibration::kBrown), run);
    if (!found || !found->converged) {
      ++failed;
      continue;
    }
    rounds = std::max(rounds, found->iterations);
    for (std::size_t g = 0; g < kObservationGroups; ++g) {
      const double ratio = found->factors[g] * wrong[g];
      sum[g] += ratio;
      squares[g] += ratio * ratio;
      reported[g] += std::pow(found->sigma[g] / found->factors[g], 2);
      ++blocks[g];
    }
  }
  Rows rows;
  using enum ObservationGroup;  // what these blocks have
  for (const ObservationGroup group :
       {kTieImages, kControlImages, kControlPlan, kControlHeight, kPositionPlan, kPositionHeight}) {
    const auto g = static_cast<std::size_t>(group);
    const double mean = sum[g] / blocks[g], scatter = std::sqrt(std::max(0.0, squares[g] / blocks[g] - mean * mean));
    const double expected = std::sqrt(reported[g] / blocks[g]);
    rows.push_back(
        {fmt::format("variance component of {}", words_of(group)),
         "sigmas wrong threefold recovered within 5 %, scatter as its own sigma says (within a third)",
         fmt::format("{:.3f} of the true one on average; scatter {:.3f}, told {:.3f}", mean, scatter, expected),
         std::abs(mean - 1) < 0.05 && scatter < 1.33 * expected && scatter > 0.67 * expected});
  }
  rows.push_back({"variance components settle", "in all blocks",
                  fmt::format("{} of {} not; at most {} rounds", failed, effort.gross_error_blocks, rounds),
                  failed == 0});
  return rows;
}

}  // namespace collinea::bench
