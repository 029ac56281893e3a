// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/stereo_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/base/units.h"
#include "collinea/dense/internal/pair_check.h"
#include "collinea/dense/working_images.h"

namespace collinea {
namespace {

constexpr double kReducedPixels = 4e6;
constexpr int kPart_px = 768, kLeastPart_px = 256;
constexpr int kMargin_px = 48;          // of a part: paths forget their beginning, windows have their neighbours
constexpr double kLargestWork = 100e6;  // pixels times disparities of a part, a byte each
constexpr double kRareOnEitherSide = 0.001;
constexpr double kWider = 1.0 / 6;
constexpr int kReducedWider_px = 2;
constexpr std::size_t kFewestValues = 200;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

struct Rectangle {
  int x0, y0, x1, y1;  // ends excluded

  [[nodiscard]] Rectangle widened(int margin, int width, int height) const {
    return {std::max(x0 - margin, 0), std::max(y0 - margin, 0), std::min(x1 + margin, width),
            std::min(y1 + margin, height)};
  }
  [[nodiscard]] double area() const { return double(x1 - x0) * double(y1 - y0); }
};

GreyImage cropped(const GreyImage& image, const Rectangle& part) {
  GreyImage out(part.x1 - part.x0, part.y1 - part.y0);
  for (int y = 0; y < out.height; ++y) std::copy_n(image.row(part.y0 + y) + part.x0, out.width, out.row(y));
  return out;
}

bool is_empty(const GreyImage& image, const Rectangle& part) {
  for (int y = part.y0; y < part.y1; ++y)
    if (std::any_of(image.row(y) + part.x0, image.row(y) + part.x1, [](std::uint8_t grey) { return grey != 0; }))
      return false;
  return true;
}

// Whether the right image has something for a part.
bool is_shown(const Rectangle& part, const DisparityRange& range, int right_width) {
  return part.x1 - range.low > 0 && part.x0 - range.high < right_width;
}

// Disparities of the reduced pair.
class Reduced {
 public:
  static Result<Reduced> of(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
                            const StereoOptions& options, const Run& run) {
    GreyImage small_left = halved(left), small_right = halved(right);
    int shrink = 2;
    for (; small_left.data.size() > std::size_t(kReducedPixels); shrink *= 2) {
      small_left = halved(small_left);
      small_right = halved(small_right);
    }
    const DisparityRange small{int(std::floor(double(range.low) / shrink)) - 1,
                               int(std::ceil(double(range.high) / shrink)) + 1};
    COLLINEA_TRY(DisparityMap map, match_pair(small_left, small_right, small, options, run));
    return Reduced(std::move(map.disparity), shrink, double(small.high - small.low + 1), range);
  }

  [[nodiscard]] double work() const { return double(disparity_.data.size()) * labels_; }

  // Of what lies in a part, or round it where that has too little.
  [[nodiscard]] DisparityRange range_of(const Rectangle& part) const {
    for (int margin = kMargin_px / shrink_;; margin = 2 * margin + 8) {
      const Rectangle small =
          Rectangle{part.x0 / shrink_, part.y0 / shrink_, part.x1 / shrink_, part.y1 / shrink_}.widened(
              margin, disparity_.width, disparity_.height);
      std::vector<float> values = values_in(small);
      if (values.size() >= kFewestValues) return range_of(values);
      if (small.area() >= double(disparity_.data.size())) return whole_;
    }
  }

 private:
  Reduced(FloatImage disparity, int shrink, double labels, const DisparityRange& whole)
      : disparity_(std::move(disparity)), shrink_(shrink), labels_(labels), whole_(whole) {}

  [[nodiscard]] std::vector<float> values_in(const Rectangle& part) const {
    std::vector<float> values;
    for (int y = part.y0; y < part.y1; ++y)
      std::copy_if(disparity_.row(y) + part.x0, disparity_.row(y) + part.x1, std::back_inserter(values),
                   [](float value) { return !std::isnan(value); });
    return values;
  }

  [[nodiscard]] DisparityRange range_of(std::vector<float>& values) const {
    const auto rare = std::ptrdiff_t(kRareOnEitherSide * double(values.size()));
    std::nth_element(values.begin(), values.begin() + rare, values.end());
    const double low = double(values[std::size_t(rare)]);
    std::nth_element(values.begin(), values.end() - 1 - rare, values.end());
    const double high = double(values[values.size() - 1 - std::size_t(rare)]);
    const double wider = kReducedWider_px + kWider * (high - low);
    return {std::max(int(std::floor(shrink_ * (low - wider))), whole_.low),
            std::min(int(std::ceil(shrink_ * (high + wider))), whole_.high)};
  }

  FloatImage disparity_;
  int shrink_;
  double labels_;
  DisparityRange whole_;
};

class Division {
 public:
  Division(const GreyImage& left, const GreyImage& right, const Reduced& reduced)
      : left_(left), right_(right), reduced_(reduced) {}

  // A part, or smaller ones where it would take too much; these may have less relief.
  void add(const Rectangle& part) {
    const DisparityRange range = reduced_.range_of(part);
    if (range.high < range.low || !is_shown(part, range, right_.width) || is_empty(left_, part)) return;
    const double work = part.widened(kMargin_px, left_.width, left_.height).area() * double(range.high - range.low + 1);
    const int width = part.x1 - part.x0, height = part.y1 - part.y0;
    if (work > kLargestWork && std::max(width, height) > kLeastPart_px) {
      const int x = part.x0 + (width + 1) / 2, y = part.y0 + (height + 1) / 2;
      for (const Rectangle& quarter : {Rectangle{part.x0, part.y0, x, y}, Rectangle{x, part.y0, part.x1, y},
                                       Rectangle{part.x0, y, x, part.y1}, Rectangle{x, y, part.x1, part.y1}})
        if (quarter.x1 > quarter.x0 && quarter.y1 > quarter.y0) add(quarter);
      return;
    }
    made.parts.push_back({part.x0, part.y0, width, height, range});
    made.work += work;
  }

  StereoParts made;

 private:
  const GreyImage &left_, &right_;
  const Reduced& reduced_;
};

}  // namespace

Result<StereoParts> stereo_parts(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
                                 const StereoOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (left.width < 2 || left.height < 2 || right.width < 2)
    return fail(Errc::kBadInput, "an image of the pair is empty");
  if (left.height != right.height) return fail(Errc::kBadInput, "the images of a rectified pair have the same height");
  COLLINEA_TRY(const Reduced reduced, Reduced::of(left, right, range, options, run));
  Division division(left, right, reduced);
  for (const Unit& tile : tiles_over(left.width, left.height, kPart_px, kPart_px)) {
    const int x = int(tile.first) * kPart_px, y = int(tile.second) * kPart_px;
    division.add({x, y, std::min(x + kPart_px, left.width), std::min(y + kPart_px, left.height)});
  }
  division.made.work_before = reduced.work();
  return std::move(division.made);
}

Result<DisparityMap> match_part(const GreyImage& left, const GreyImage& right, const StereoPart& part,
                                const StereoOptions& options, const Run& run) {
  const Rectangle wide = Rectangle{part.column, part.row, part.column + part.width, part.row + part.height}.widened(
      kMargin_px, left.width, left.height);
  DisparityMap map{FloatImage(part.width, part.height, 1, kNaN), FloatImage(part.width, part.height, 1, kNaN)};
  // Of the right image all that the wide part may show, with the windows round it.
  const Rectangle there{std::max(wide.x0 - part.range.high - kMargin_px, 0), wide.y0,
                        std::min(wide.x1 - part.range.low + kMargin_px, right.width), wide.y1};
  if (there.x1 <= there.x0) return map;
  const int shift = there.x0 - wide.x0;  // of disparities
  const GreyImage own = cropped(left, wide), other = cropped(right, there);
  const DisparityRange range{part.range.low + shift, part.range.high + shift};
  if (range.low >= own.width || range.high <= -other.width) return map;
  COLLINEA_TRY(const DisparityMap found, match_pair(own, other, range, options, run));
  const int x0 = part.column - wide.x0, y0 = part.row - wide.y0;
  for (int y = 0; y < part.height; ++y) {
    std::transform(found.disparity.row(y0 + y) + x0, found.disparity.row(y0 + y) + x0 + part.width,
                   map.disparity.row(y), [&](float disparity) { return disparity - float(shift); });
    std::copy_n(found.sigma.row(y0 + y) + x0, part.width, map.sigma.row(y));
  }
  return map;
}

}  // namespace collinea
