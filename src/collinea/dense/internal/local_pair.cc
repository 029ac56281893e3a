// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/local_pair.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "collinea/base/parallel.h"
#include "collinea/match/census.h"

namespace collinea::dense {
namespace {

constexpr int kBitsOfByte = 8;

std::size_t planes_of(Similarity similarity, int neighbourhood_px) {
  if (similarity != Similarity::kCensus) return 1;
  return std::size_t((neighbourhood_px * neighbourhood_px - 1) / kBitsOfByte);
}

bool is_of_neighbours(Similarity similarity) {
  return similarity == Similarity::kRank || similarity == Similarity::kCensus;
}

}  // namespace

LocalPlanes::LocalPlanes(const GreyImage& image, Similarity similarity, int half_px, int neighbourhood_px,
                         const Run& run)
    : planes_(planes_of(similarity, neighbourhood_px),
              GreyImage(image.width + 2 * half_px + kLocalSlack, image.height)),
      half_(half_px) {
  parallel_for(run, std::size_t(image.height), [&](std::size_t item) {
    const int y = int(item);
    for (int x = 0; x < image.width; ++x) {
      if (!is_of_neighbours(similarity)) {
        planes_[0].at(x + half_, y) = image.at(x, y);
        continue;
      }
      const std::uint64_t bits = darker_neighbours(image, x, y, neighbourhood_px / 2);
      if (similarity == Similarity::kRank)
        planes_[0].at(x + half_, y) = std::uint8_t(std::popcount(bits));
      else
        for (std::size_t i = 0; i < planes_.size(); ++i)
          planes_[i].at(x + half_, y) = std::uint8_t(bits >> (kBitsOfByte * i));
    }
    for (GreyImage& plane : planes_) {
      std::uint8_t* row = plane.row(y);
      std::fill_n(row, half_, row[half_]);
      std::fill_n(row + half_ + image.width, half_, row[half_ + image.width - 1]);
    }
  });
}

const std::uint8_t* LocalPlanes::row(std::size_t plane, int y) const {
  const GreyImage& of = planes_[plane];
  return of.row(std::clamp(y, 0, of.height - 1));
}

LocalMoments local_moments(const LocalPlanes& grey, int width, int height, int half_px, bool is_about_mean) {
  const int side = 2 * half_px + 1, padded = width + 2 * half_px;
  const double pixels = double(side) * side;
  LocalMoments made{{width + kLocalSlack, height}, {width + kLocalSlack, height}};
  std::vector<std::int32_t> sums(std::size_t(padded), 0), squares(sums);
  for (int y = -half_px; y < height + half_px; ++y) {
    const std::uint8_t* entering = grey.row(0, y);
    const std::uint8_t* leaving = y >= half_px + 1 ? grey.row(0, y - side) : nullptr;
    for (std::size_t x = 0; x < sums.size(); ++x) {
      sums[x] += entering[x] - (leaving ? leaving[x] : 0);
      squares[x] += entering[x] * entering[x] - (leaving ? leaving[x] * leaving[x] : 0);
    }
    if (y < half_px) continue;
    std::int32_t sum = 0, square = 0;
    for (int x = 0; x < padded; ++x) {
      sum += sums[std::size_t(x)];
      square += squares[std::size_t(x)];
      if (x < side - 1) continue;
      const double spread = square - double(sum) * sum / pixels;
      made.sum.at(x - side + 1, y - half_px) = is_about_mean ? sum : 0;
      // Whole numbers: below half of the least spread there can be is rounding.
      made.scale.at(x - side + 1, y - half_px) =
          spread > 0.5 / pixels ? float(1 / std::sqrt(is_about_mean ? spread : double(square))) : 0;
      sum -= sums[std::size_t(x - side + 1)];
      square -= squares[std::size_t(x - side + 1)];
    }
  }
  return made;
}

LocalPair::LocalPair(const GreyImage& left_image, const GreyImage& right_image, Similarity similarity, int half_px,
                     int neighbourhood_px, const Run& run)
    : left(left_image),
      right(right_image),
      half(half_px),
      left_planes(left, similarity, half, neighbourhood_px, run),
      right_planes(right, similarity, half, neighbourhood_px, run) {
  const auto moments = [&](const GreyImage& image) {
    return local_moments(LocalPlanes(image, Similarity::kNcc, half, neighbourhood_px, run), image.width, image.height,
                         half, similarity != Similarity::kCosine);
  };
  left_moments = moments(left);
  if (is_larger_better(similarity)) right_moments = moments(right);
}

}  // namespace collinea::dense
