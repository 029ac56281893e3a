// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace collinea::bundle {

/// Which images share points: of each image the others, ascending.
using Covisibility = std::vector<std::vector<int>>;

/// From the images of every point by CSR: those of point p are image_of_ray[first[p]] up to first[p + 1].
[[nodiscard]] Covisibility covisibility(int images, const std::vector<std::uint32_t>& first,
                                        const std::vector<int>& image_of_ray);

/// Orders images for elimination: answers the new number of each. Of two orders that with less work in Cholesky's
/// factor, kept in tiles of `per_tile` images:
///   - nested dissection (George 1973), for large blocks: the block is cut in two by the fewest images whose removal
///     separates the rest; these come last, the halves are ordered likewise. Cuts are looked for across the principal
///     axes of the projection centres and along a walk through the graph. What comes before a cut's images fills whole
///     tiles, so that no tile holds images of two halves: what is left over goes up with them;
///   - reverse Cuthill-McKee, for small and narrow ones: images that share points are close together.
[[nodiscard]] std::vector<int> elimination_order(const Covisibility& graph, const std::vector<Eigen::Vector3d>& centres,
                                                 int per_tile);

}  // namespace collinea::bundle
