// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/block/block.h"
#include "collinea/quality/internal/hypothesis.h"

namespace collinea::bundle {

/// All hypotheses that the block has observations for.
[[nodiscard]] HypothesisColumns lay_out_hypotheses(const Solved& solved, const SystematicOptions& options);

/// What the families of hypotheses share while they are laid out: the flight, and the columns numbered so far.
struct HypothesisLayout {
  HypothesisLayout(const Solved& solved, const SystematicOptions& options, HypothesisColumns& out);

  Hypothesis& add(SystematicKind kind, const char* unit, const char* effect_unit, std::vector<int> columns);
  [[nodiscard]] bool is_of_camera(std::uint32_t image, std::size_t camera) const {
    return problem.images[image].camera == static_cast<int>(camera);
  }

  const Block& block;
  const Problem& problem;
  const SystematicOptions& options;
  HypothesisColumns& out;
  std::vector<std::vector<int>> strips;  ///< poses in the order flown
  bool timed = false;                    ///< velocities are per second; otherwise from one image to the next
  int next = 0;                          ///< number of the next column
};

/// first, first + 1 ...
[[nodiscard]] std::vector<int> range(int first, int count);

/// Errors of positions and attitudes: time offset, lever arm, shift, vertical datum, drift, assignment, boresight.
void add_hypotheses_of_instruments(HypothesisLayout& layout);
/// Errors of images: affinity, additional parameters, rolling shutter, refraction.
void add_hypotheses_of_images(HypothesisLayout& layout);
/// The bowl: the shape of the block against heights that are given.
void add_hypothesis_of_bowl(HypothesisLayout& layout);

}  // namespace collinea::bundle
