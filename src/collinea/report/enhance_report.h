// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/io/text_table.h"
#include "collinea/raster/grey_table.h"

namespace collinea {

/// What was done to an image, in its order, and the grey values after each of it.
struct EnhanceStep {
  std::string name;  ///< "image" first
  int width = 0, height = 0;
  GreyHistogram histogram;
};

struct EnhanceReport {
  std::string image;  ///< file
  int channels = 1;
  double empty_share = 0;  ///< of the pixels of the file, which count nowhere
  std::vector<EnhanceStep> steps;
  std::optional<int> black, white;  ///< of a stretch: the grey values that became 0 and 255
  std::optional<int> threshold;     ///< as used
  bool is_threshold_found = false;  ///< by Otsu's rule
  std::vector<GreyTable> table;     ///< the one that stands for all point operations together; empty: there was none
};

/// A row a step: size, least, quantiles, largest, mean, contrast, entropy, shares of black and white.
[[nodiscard]] TextTable grey_statistics_table(const EnhanceReport& report);
/// A row a grey value: how many pixels before and after, cumulative shares, and its new value where tables were used.
[[nodiscard]] TextTable histogram_table(const EnhanceReport& report);
/// The histogram before and after with cumulative curves: a picture by itself.
[[nodiscard]] std::string histogram_svg(const EnhanceReport& report);
/// For a terminal.
[[nodiscard]] std::string enhance_text(const EnhanceReport& report);

}  // namespace collinea
