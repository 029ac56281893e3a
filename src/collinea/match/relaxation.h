// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "collinea/base/options.h"

// Which of several candidates a point of one image matches in another, by what its neighbours match (relaxation:
// Barnard and Thompson 1980; Mussio 7.9, A.2). docs/theory/relaxation.md.
namespace collinea {

/// A position of the other image that may be the point.
struct CandidatePosition {
  Eigen::Vector2d position_px;
  double similarity = 0;  ///< correlation, 0 to 1
};

/// A point, where it is expected in the other image, and what is there.
struct PointCandidates {
  Eigen::Vector2d point_px, expected_px;
  std::vector<CandidatePosition> candidates;
};

struct RelaxationOptions {
  int neighbours = 12;              ///< nearest points that are asked
  double parallax_gradient = 0.05;  ///< sigma of the difference of two parallaxes, for each pixel that points lie apart
  double least_probability = 0.7;   ///< of a candidate that is taken
  int iterations = 20;              ///< rounds in which neighbours are asked

  friend bool operator==(const RelaxationOptions&, const RelaxationOptions&) = default;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RelaxationOptions;
    visit(Field{"neighbours", &O::neighbours, "1", "nearest points that are asked", 1, 1000});
    visit(Field{"parallax_gradient", &O::parallax_gradient, "1",
                "sigma of the difference of two parallaxes for each pixel that their points lie apart, beside 1 px", 0,
                10});
    visit(Field{"least_probability", &O::least_probability, "1", "of a candidate that is taken", 0.5, 1});
    visit(Field{"iterations", &O::iterations, "1", "rounds in which neighbours are asked", 1, 1000});
  }
};

/// How a point was decided: 0, 1 or many candidates.
enum class RelaxedOutcome {
  kNoCandidate,
  kOne,        ///< a single candidate, which the neighbours bear out
  kChosen,     ///< of several
  kUndecided,  ///< none is decisively better, or the neighbours contradict
  kTaken,      ///< another point, more probable, matches the same position
};

struct RelaxedMatch {
  RelaxedOutcome outcome = RelaxedOutcome::kNoCandidate;
  std::optional<std::size_t> candidate;  ///< where it is kOne or kChosen
  double probability = 0;                ///< of the best candidate
};

/// Decides for every point, in their order. Probabilities begin with the similarities, one label being that no
/// candidate is right; in each round that of a candidate is multiplied by 0.3 + 3 q, q being the mean over the
/// neighbours of how probable candidates with a like parallax are. Parallax is the position less the expected one; two
/// are alike by a normal curve whose standard deviation is 1 px and the gradient times the distance.
[[nodiscard]] std::vector<RelaxedMatch> relax(const std::vector<PointCandidates>& points,
                                              const RelaxationOptions& options);

}  // namespace collinea
