// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/rejection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace collinea {
namespace {

// The variance of what the others predict, from w, which has it: g = w sigma sqrt(own^2 + sigma0^2 q), where sigma0
// multiplies the sigmas of image points too (own) and those of all others stay as given.
double cofactor_by_others(const TestedObservation& one, double sigma0) {
  if (!std::isfinite(one.w)) return std::numeric_limits<double>::quiet_NaN();
  const double own = is_image_point(one.group) ? sigma0 : 1;
  const double spread = one.gross_error / one.w / one.sigma;
  return std::max(0.0, (spread * spread - own * own) / (sigma0 * sigma0));
}

Rejection rejection_of(const ChosenSuspect& one, const Measurements& all, double sigma0, int round) {
  Rejection rejected{.given = given_at({one.test.group, one.test.source}, all),
                     .sigma = one.test.sigma,
                     .cofactor = cofactor_by_others(one.test, sigma0)};
  static_cast<Measurement&>(rejected.rejected) = one.measurement;
  rejected.rejected.axis = one.test.axis;
  rejected.rejected.w = one.test.w;
  rejected.rejected.limit = one.test.limit;
  rejected.rejected.redundancy = one.test.redundancy;
  rejected.rejected.influence = one.test.gross_error - one.test.residual;
  rejected.rejected.as_pair = one.as_pair;
  rejected.rejected.round = round;
  return rejected;
}

}  // namespace

Remaining reject(Remaining remaining, const SuspectChoice& choice, double sigma0, int round) {
  std::vector<MeasurementIndex> indices = choice.last_rays;
  for (const ChosenSuspect& one : choice.suspects) {
    indices.push_back({one.test.group, one.test.source});
    remaining.rejections.push_back(rejection_of(one, remaining.measurements, sigma0, round));
  }
  remaining.measurements = without(std::move(remaining.measurements), indices);
  return remaining;
}

std::vector<std::size_t> agreeing(const Remaining& remaining, double limit, const std::set<Measurement>& tried) {
  std::map<PointId, int> rays;
  for (const Observation& seen : remaining.measurements.block.observations) ++rays[seen.point];
  std::set<Measurement> put_back = tried;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < remaining.rejections.size(); ++i) {
    const Rejected& rejected = remaining.rejections[i].rejected;
    const bool point_is_there = !rejected.point.valid() || rays[rejected.point] >= 2;
    if (!rejected.as_pair && point_is_there &&
        std::abs(rejected.gross_error[rejected.axis]) < std::max(limit, rejected.limit) * rejected.sigma &&
        put_back.insert(rejected).second)
      indices.push_back(i);
  }
  return indices;
}

Remaining put_back(Remaining remaining, const std::vector<std::size_t>& indices) {
  std::vector<Rejection> still_rejected;
  std::size_t next = 0;
  for (std::size_t i = 0; i < remaining.rejections.size(); ++i) {
    Rejection& one = remaining.rejections[i];
    if (next < indices.size() && indices[next] == i) {
      remaining.measurements = with(std::move(remaining.measurements), one.rejected, one.given);
      ++next;
    } else {
      still_rejected.push_back(std::move(one));
    }
  }
  remaining.rejections = std::move(still_rejected);
  return remaining;
}

}  // namespace collinea
