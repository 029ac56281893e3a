// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/models/control_similarity.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

/// Why a model takes no part.
enum class LeftOutReason {
  kNoPoint,    ///< shares no point with the others, nor with control
  kTooFew,     ///< shares one or two points: it can turn about them
  kOnLine,     ///< shares points on one line only
  kNoControl,  ///< hangs together with other models, but apart from the block and without control of its own
};

struct LeftOutModel {
  std::size_t model = 0;  ///< index
  LeftOutReason reason{};
  int shared = 0;  ///< points in common with what is joined
};

/// How a model came into its part of the chain.
struct ChainLink {
  std::size_t model = 0;               ///< index
  std::optional<std::size_t> partner;  ///< by the points of this one; nothing: by those of all that were there
};

/// Models that hang together without control; the first one bears the others.
using ChainPart = std::vector<ChainLink>;

/// Approximate values of a block: every model's similarity to the ground and all points.
struct ModelChain {
  std::vector<std::optional<Similarity3>> ground_from_model;  ///< parallel to the models
  std::map<std::string, Eigen::Vector3d> points;              ///< mean of the models that show it
  std::vector<LeftOutModel> left_out;
  bool on_ground = false;  ///< false: no control; the frame is that of `reference`
  std::size_t reference = 0;
  std::vector<ChainPart> parts;  ///< in the order in which they came to the ground; what was left out is in none
};

/// Concatenates models (Mussio 3.3.5) along the tree of the strongest links: begins with the model that shares most
/// points and brings to it, one after another, the model that is best fixed by the points that it has in common with
/// one that is there (by the second axis of their spread; three that are not on a line, at least), by least squares. A
/// model that none of them fixes is joined to the points of all. The chain gets its absolute orientation by control
/// (control_similarity()). What hangs together apart from it is a chain of its own, which is oriented by its own
/// control and by the points that it shares with what is on the ground. Without any control the frame of the first
/// model remains.
///
/// Errors: kBadInput (no model; a name twice in a model; coordinates that are no numbers); kIllPosed: no two models can
/// be joined, or there is control but it does not fix the block, with what is missing.
/// Cost: quadratic in the models, linear in the points.
[[nodiscard]] Result<ModelChain> chain_models(const std::vector<StereoModel>& models,
                                              const std::vector<SurveyedPoint>& control);

}  // namespace collinea
