// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/tie_point_colours.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "collinea/base/parallel.h"

namespace collinea {

Result<> colour_tie_points(const PixelSource& pixels, Block& block, const Run& run) {
  constexpr int kShrink = 8;  // a feature covers more than a few pixels, and decoding is what costs
  std::map<ImageId, std::vector<const Observation*>> by_image;
  PointId last;
  for (const Observation& seen : block.observations) {  // sorted by point: the first of each
    if (seen.point != last) by_image[seen.image].push_back(&seen);
    last = seen.point;
  }
  std::vector<std::pair<ImageId, std::vector<const Observation*>>> work(by_image.begin(), by_image.end());
  parallel_for(run, work.size(), [&](std::size_t i) {
    const auto image = pixels(work[i].first, kShrink);
    if (!image) return;
    for (const Observation* seen : work[i].second) {
      const int x = std::clamp(static_cast<int>(seen->pixel.x() / kShrink), 0, image->width - 1);
      const int y = std::clamp(static_cast<int>(seen->pixel.y() / kShrink), 0, image->height - 1);
      auto& colour = block.points.at(seen->point).colour;
      for (int c = 0; c < 3; ++c) colour[static_cast<std::size_t>(c)] = image->at(x, y, image->channels == 3 ? c : 0);
    }
  });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  return {};
}

}  // namespace collinea
