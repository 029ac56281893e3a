// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/marking_block.h"

namespace collinea {

std::map<ImageId, std::vector<std::size_t>> observations_by_image(const Block& block) {
  std::map<ImageId, std::vector<std::size_t>> all;
  for (std::size_t i = 0; i < block.observations.size(); ++i) all[block.observations[i].image].push_back(i);
  return all;
}

}  // namespace collinea
