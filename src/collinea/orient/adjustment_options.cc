// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/adjustment_options.h"

namespace collinea {

InstrumentOptions changed(InstrumentOptions instruments, const InstrumentChanges& changes) {
  if (changes.lever_arm) instruments.lever_arm = changes.lever_arm;
  if (changes.position_shift) instruments.position_shift = *changes.position_shift;
  if (changes.position_drift) instruments.position_drift = *changes.position_drift;
  if (changes.time_offset) instruments.time_offset = *changes.time_offset;
  if (changes.use_attitudes) instruments.use_attitudes = *changes.use_attitudes;
  if (changes.attitude_sigma_deg) instruments.attitude_sigma_deg = *changes.attitude_sigma_deg;
  if (changes.heading_sigma_deg) instruments.heading_sigma_deg = *changes.heading_sigma_deg;
  return instruments;
}

}  // namespace collinea
