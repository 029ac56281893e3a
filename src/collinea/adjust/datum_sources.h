// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// What fixes position, attitude and scale of a block, as far as anything does.
struct DatumSources {
  bool control = false;
  bool positions = false;  ///< of images
  bool attitudes = false;  ///< of images, or what is known of up
  bool geodetic = false;   ///< geodetic observations
  bool fixed = false;      ///< images or points that are fixed
  int parts = 0;           ///< that no tie point connects

  friend bool operator==(const DatumSources&, const DatumSources&) = default;
};

}  // namespace collinea
