// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace collinea {

/// Where the first focal length of a camera came from.
enum class Provenance : std::uint8_t {
  kUnknown,
  kExifPixelPitch,  ///< focal length and pixel pitch in the header of the image
  kExif35mm,        ///< focal length of the equivalent of 35 mm film there
  kAssumed,         ///< a usual one: the header states none, or an impossible one
  kGiven,           ///< by the user, or in a file of another program
  kSimulated,       ///< the nominal one of a simulated survey
  kTrue,            ///< of a simulated survey, without error
};
inline constexpr std::array<std::string_view, 7> kProvenanceNames = {
    "", "EXIF focal length and pixel pitch", "EXIF 35 mm equivalent", "assumed", "given", "simulated", "true"};

/// What is known of a camera before adjustment, apart from the values that it starts with.
struct CameraPrior {
  double sigma_f_px = 0;  ///< of the focal length; 0 = held fixed
  bool calibrate = true;  ///< false: all parameters are given and held fixed
  Provenance source = Provenance::kUnknown;

  [[nodiscard]] std::string_view source_name() const { return kProvenanceNames[static_cast<std::size_t>(source)]; }
};

}  // namespace collinea
