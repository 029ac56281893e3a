// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/mark_tone.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

TEST(MarkTone, GreyIsAPowerOfMixedLight) {
  const ToneCurve curve(180, 20, 2.2);
  const double ground = std::pow(20, 2.2), mark = std::pow(200, 2.2);
  for (const double share : {0.0, 0.1, 0.5, 1.0})
    EXPECT_NEAR(curve.at(share).grey, std::pow(ground + share * (mark - ground), 1 / 2.2), 1e-9);
  EXPECT_NEAR(ToneCurve(180, 20, 1).at(0.3).grey, 74, 1e-12);
  EXPECT_NEAR(ToneCurve(180, 20, 0).at(0.5).grey, std::sqrt(20 * 200.0), 0.1);  // geometric mean, to the tone's 0.001
}

// Against differences of 1e-6, good to some 1e-8 of a grey value of 200.
TEST(MarkTone, DerivativesAreThoseOfTheGreyValue) {
  for (const double tone : {-1.0, 0.5, 1.0, 1.000001, 2.2})
    for (const double gain : {180.0, -150.0})
      for (const double share : {0.05, 0.4, 0.9}) {
        const double offset = gain > 0 ? 20 : 190, h = 1e-6;
        const auto grey = [&](double g, double o, double t, double s) { return ToneCurve(g, o, t).at(s).grey; };
        const TonedGrey at = ToneCurve(gain, offset, tone).at(share);
        const auto slope = [&](double more, double less) { return (more - less) / (2 * h); };
        const auto close = [&](double value) { return 1e-5 * (1 + std::abs(value)); };
        EXPECT_NEAR(at.by_share, slope(grey(gain, offset, tone, share + h), grey(gain, offset, tone, share - h)),
                    close(at.by_share));
        EXPECT_NEAR(at.by_gain, slope(grey(gain + h, offset, tone, share), grey(gain - h, offset, tone, share)), 1e-5);
        EXPECT_NEAR(at.by_offset, slope(grey(gain, offset + h, tone, share), grey(gain, offset - h, tone, share)),
                    1e-5);
        const double by_tone = ToneCurve(gain, offset, tone).by_tone(share);
        EXPECT_NEAR(by_tone, slope(grey(gain, offset, tone + h, share), grey(gain, offset, tone - h, share)),
                    close(by_tone))
            << tone << " " << gain << " " << share;
      }
}

TEST(MarkTone, BlackGroundAndNoMarkHaveGreyValues) {
  for (const double share : {-0.01, 0.0, 0.5, 1.0, 1.01}) {
    EXPECT_TRUE(std::isfinite(ToneCurve(200, -5, 2.2).at(share).grey));
    EXPECT_TRUE(std::isfinite(ToneCurve(200, -5, 2.2).at(share).by_offset));
    EXPECT_NEAR(ToneCurve(0, 50, 2.2).at(share).grey, 50, 1e-9);
    EXPECT_EQ(ToneCurve(0, 50, 2.2).by_tone(share), 0);
  }
}

}  // namespace
}  // namespace collinea
