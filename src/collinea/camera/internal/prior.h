// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "collinea/base/words.h"
#include "collinea/camera/film_prior.h"

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
inline constexpr Word<Provenance> kProvenanceWords[] = {
    {Provenance::kUnknown, "unknown"},    {Provenance::kExifPixelPitch, "exif_pixel_pitch"},
    {Provenance::kExif35mm, "exif_35mm"}, {Provenance::kAssumed, "assumed"},
    {Provenance::kGiven, "given"},        {Provenance::kSimulated, "simulated"},
    {Provenance::kTrue, "true"}};
constexpr std::span<const Word<Provenance>> words(Provenance) { return kProvenanceWords; }

/// What is known of a camera before adjustment, apart from the values that it starts with.
struct CameraPrior {
  double sigma_f_px = 0;  ///< of the focal length; 0: fixed
  bool calibrate = true;  ///< false: all parameters are given and fixed
  Provenance source = Provenance::kUnknown;
  std::optional<FilmPrior> film = {};  ///< of the scan of a film, whose camera it is: how it is deformed
};

}  // namespace collinea
