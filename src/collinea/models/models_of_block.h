// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

struct ModelPairChoice {
  int least_points = 8;      ///< in common
  double least_share = 0.6;  ///< of the points that the image has in common with its best partner
  int most_points = 60;      ///< that a model keeps
};

/// A pair of images that makes a model, or could not.
struct FormedModel {
  ImageId left, right;
  int points = 0, rejected = 0;
  double sigma0 = 0;    ///< of its relative orientation
  std::string failure;  ///< why there is no model; empty: there is
};

struct ModelsOfBlock {
  std::vector<FormedModel> pairs;
  std::vector<StereoModel> models;  ///< of those that did not fail
  std::vector<SurveyedPoint> control;
};

/// Which pairs of images make models: those with most points in common, each image in two models at most and no ring
/// of models, as neighbours in strips are.
[[nodiscard]] std::vector<std::pair<ImageId, ImageId>> model_pairs(const Block& block, const ModelPairChoice& choice);

/// The models of a block: of each pair its relative orientation by its own image measurements alone
/// (relative_orientation(), gross errors are left out), and the coordinates of its points and its two projection
/// centres (named as the images) with their full covariance, in the frame of the left photograph (x right, y up, z
/// backwards) and in units of the base. Of more than `most_points` every so many are kept, control and what is in most
/// images first. Tie points are named by their numbers. Poses of the block are not looked at; its cameras are taken as
/// exact. `sigmas_known`: covariances are by the sigmas of the image points, else by each model's own sigma0.
/// Errors: no pair has enough points; names of control that are names of images or tie points.
[[nodiscard]] Result<ModelsOfBlock> models_of_block(const Block& block,
                                                    const std::vector<std::pair<ImageId, ImageId>>& pairs,
                                                    const ModelPairChoice& choice, bool sigmas_known, const Run& run);

}  // namespace collinea
