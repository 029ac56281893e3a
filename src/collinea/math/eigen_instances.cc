// SPDX-License-Identifier: Apache-2.0
#define COLLINEA_EIGEN_INSTANCE template
#include "collinea/math/eigen_instances.h"
