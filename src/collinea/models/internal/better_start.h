// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/run.h"
#include "collinea/models/model_chain.h"

namespace collinea {

/// A chain of hundreds of models bends: errors of its links add up to more than least squares can take for linear. Puts
/// the result of Anblock, from models that are levelled by the chain, in its place where models then agree better with
/// each other and with control.
[[nodiscard]] ModelChain better_start(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
                                      ModelChain chain, const Run& run);

}  // namespace collinea
