// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/plotted_vertex.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/adjust/test_block.h"
#include "collinea/math/random.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::test_block;
using testing::TestBlockOptions;
}  // namespace
}  // namespace collinea
