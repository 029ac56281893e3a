// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// The grey value of a pixel, and its derivatives.
struct TonedGrey {
  double grey, by_share, by_gain, by_offset;
};

/// Grey values between those of ground and mark where a drawing is between 0 and 1: light mixes, and a scanner writes a
/// power of it, light = grey^tone,
///
///     grey = (offset^tone + share ((offset + gain)^tone - offset^tone))^(1 / tone).
///
/// 1: grey values are light. Ground and mark are at least one grey value bright.
class ToneCurve {
 public:
  ToneCurve(double gain, double offset, double tone);
  [[nodiscard]] TonedGrey at(double share) const;
  [[nodiscard]] double by_tone(double share) const;

 private:
  double gain_, offset_, tone_;
  double ground_, mark_, log_ratio_, rise_;
};

}  // namespace collinea
