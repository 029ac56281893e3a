// SPDX-License-Identifier: Apache-2.0
// The foreign headers that nearly every file reads, read once for all of them. Of our own only the list of what is compiled
// once for all belongs here: a file still includes what it uses, as the preset dev (which has no precompiled header and no
// unity build) shows.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Dense>
#include <tl/expected.hpp>

#include "collinea/math/eigen_instances.h"
