// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/geodetic_scale.h"

#include <algorithm>
#include <cmath>

#include "collinea/epipolar/intersect.h"

namespace collinea {
namespace {

constexpr double kAgree = 5;                  // sigmas: no chance explains more
constexpr double kLeastContradiction = 1e-3;  // relative; less does no harm, and the block itself bends as much

struct Ratio {
  std::size_t index;
  double value, sigma;  // given over intersected length; sigma relative
  [[nodiscard]] double weight() const { return 1 / (sigma * sigma); }
};

std::vector<Ratio> ratios_of(const Block& block) {
  std::vector<Ratio> ratios;
  for (std::size_t i = 0; i < block.geodetic.size(); ++i) {
    const GeodeticObservation& one = block.geodetic[i];
    // Heights of instrument and target need to know what is up.
    if (one.kind != GeodeticKind::kDistance || one.role != ControlRole::kControl || one.instrument_height_m != 0 ||
        one.target_height_m != 0)
      continue;
    const auto from = intersect(sight_lines(block, one.from)), to = intersect(sight_lines(block, one.to));
    if (!from || !to) continue;
    const Eigen::Vector3d line = to->point_in_world - from->point_in_world;
    const double length = line.norm();
    if (!(length > 0)) continue;
    const Eigen::Vector3d along = line / length;
    const double seen = std::sqrt(along.dot((from->covariance + to->covariance) * along)) / length;
    ratios.push_back({i, one.value / length, std::hypot(one.sigma / one.value, seen)});
  }
  return ratios;
}

// How far two ratios are from each other, over what may part them: 1 is the most that agrees.
double distance(const Ratio& a, const Ratio& b) {
  const double allowed = std::max(kAgree * std::hypot(a.sigma, b.sigma), kLeastContradiction);
  return std::abs(a.value / b.value - 1) / allowed;
}

// The one that most agree with; of several the one they are closest to. (A median would follow one long distance.)
const Ratio& middle_of(const std::vector<Ratio>& ratios) {
  const auto cost = [&](const Ratio& middle) {
    double sum = 0;
    for (const Ratio& other : ratios) sum += std::min(1.0, std::pow(distance(other, middle), 2));
    return sum;
  };
  return *std::min_element(ratios.begin(), ratios.end(),
                           [&](const Ratio& a, const Ratio& b) { return cost(a) < cost(b); });
}

}  // namespace

std::optional<GeodeticScale> geodetic_scale(const Block& block) {
  const std::vector<Ratio> ratios = ratios_of(block);
  if (ratios.empty()) return std::nullopt;
  const Ratio& middle = middle_of(ratios);
  GeodeticScale found;
  double sum = 0, weights = 0;
  for (const Ratio& ratio : ratios) {
    const double off = ratio.value / middle.value - 1;
    if (distance(ratio, middle) > 1) {
      if (ratios.size() == 2) {
        found.findings.push_back(finding_of(FindingCode::kDistancesContradict,
                                            {Subject::geodetic(ratios[0].index), Subject::geodetic(ratios[1].index)},
                                            {{FigureName::kRelative, std::abs(off)}}, {RemedyCode::kAddDistance}));
      } else {
        found.excluded.push_back(ratio.index);
        found.findings.push_back(
            finding_of(FindingCode::kDistanceWrong, {Subject::geodetic(ratio.index)},
                       {{FigureName::kRelative, std::abs(off)},
                        {FigureName::kDifference, std::abs(off) * block.geodetic[ratio.index].value}},
                       {RemedyCode::kLookAtDistance}));
        continue;
      }
    }
    sum += ratio.weight() * ratio.value;
    weights += ratio.weight();
    ++found.distances;
  }
  found.scale = sum / weights;
  found.sigma = 1 / std::sqrt(weights);
  return found;
}

}  // namespace collinea
