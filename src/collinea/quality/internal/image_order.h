// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// The images of a strip in the order of their times.
[[nodiscard]] std::vector<ImageId> images_of_strip(const std::map<ImageId, double>& strip);

/// The images of all strips, one after the other, each once; without strips the oriented images by the times they were
/// taken, or else by their ids.
[[nodiscard]] std::vector<ImageId> order_flown(const Block& block, std::span<const std::map<ImageId, double>> strips);

}  // namespace collinea
