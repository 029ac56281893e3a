// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/gross_control.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "collinea/quality/control_check.h"

namespace collinea {
namespace {

constexpr double kGross = 100;  // sigmas: such a ray of control bends the images it is in

double offset_px(const ControlDiagnosis& diagnosis, const ControlObservation& seen) {
  double offset_px = 0;
  for (const Finding& finding : diagnosis.findings)
    if (finding.code == FindingCode::kControlMeasurement && finding.subjects[0].control() == seen.point &&
        finding.subjects[1].image() == seen.image)
      offset_px = std::max(offset_px, finding.figure(FigureName::kOffsetPx).value_or(0));
  return offset_px;
}

}  // namespace

Remaining without_gross_control(Measurements measurements, int most, std::uint64_t seed) {
  Remaining remaining{.measurements = std::move(measurements)};
  const Block& block = remaining.measurements.block;
  std::vector<MeasurementIndex> gross;
  const ControlDiagnosis diagnosis = check_control(block, seed);
  for (const std::size_t i : diagnosis.excluded_observations) {
    const ControlObservation& seen = block.control_observations[i];
    const double offset = offset_px(diagnosis, seen);
    if (offset < kGross * seen.sigma_px || static_cast<int>(gross.size()) >= most) continue;
    gross.push_back({ObservationGroup::kControlImages, static_cast<std::uint32_t>(i)});
    Rejection rejected{.given = seen, .sigma = seen.sigma_px};
    static_cast<Measurement&>(rejected.rejected) = measurement_at(gross.back(), block);
    rejected.rejected.w = offset / seen.sigma_px;
    rejected.rejected.redundancy = rejected.rejected.influence = std::numeric_limits<double>::quiet_NaN();
    remaining.rejections.push_back(rejected);
  }
  remaining.measurements = without(std::move(remaining.measurements), gross);
  return remaining;
}

}  // namespace collinea
