// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/models/model_block.h"
#include "collinea/models/models_of_block.h"

namespace collinea {

/// A point, or the projection centre of an image, as the bundle has it.
struct BundlePoint {
  Eigen::Vector3d position;    ///< [m], world
  Eigen::Matrix3d covariance;  ///< [m^2]
};

/// The bundle of the measurements that models were formed from.
struct BundleOfModels {
  std::map<std::string, BundlePoint> points;  ///< by the names that they have in the models
  double sigma0 = 0;                          ///< of image measurements, a posteriori
  long observations = 0, unknowns = 0, redundancy = 0;
};

/// Adjusts the bundle of the very measurements that `formed` models keep (an image point that relative orientation
/// rejected, or that a model dropped for its size, takes no part in any image of that model's pair unless a neighbour
/// keeps it), so that both adjustments see the same: cameras are exact as they are for models, control is `control`
/// with its sigmas (without correlations), check points take part as tie points, no loss, no GNSS, nothing on the
/// ground. Begins at the joined models; images without a pose are resected from their points.
/// `sigmas_known`: covariances are by the sigmas of the image points and of control; else times sigma0 squared.
///
/// Errors: kBadInput: the joined block has no control (its frame is then that of a model, and standard deviations of
/// two frames are not to be compared); kIllPosed: an image that its points do not orient, or those of the adjustment.
[[nodiscard]] Result<BundleOfModels> bundle_of_models(const Block& block, const ModelsOfBlock& formed,
                                                      const std::vector<SurveyedPoint>& control,
                                                      const JoinedBlock& joined, bool sigmas_known, const Run& run);

/// How joined models differ from their bundle: each sum is over the points that both have.
struct BundleComparison {
  int points = 0;
  Eigen::Vector3d apart = Eigen::Vector3d::Zero();            ///< RMS of models minus bundle [m]
  Eigen::Vector3d apart_in_sigmas = Eigen::Vector3d::Zero();  ///< RMS of that over the bundle's sigma
  Eigen::Vector3d ratio = Eigen::Vector3d::Zero();            ///< mean of the models' sigma over the bundle's
};
/// Coordinates that a bundle does not change (sigma 0) count in `apart` alone.
[[nodiscard]] BundleComparison compare(const JoinedBlock& joined, const BundleOfModels& bundle);

}  // namespace collinea
