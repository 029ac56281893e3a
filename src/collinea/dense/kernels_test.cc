// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "collinea/dense/internal/aggregate.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/match_kernels.h"
#include "collinea/dense/internal/path_kernels.h"
#include "collinea/dense/internal/texture.h"
#include "collinea/math/random.h"

namespace collinea::dense {
namespace {

GreyImage random_image(int width, int height, std::uint64_t seed) {
  GreyImage image(width, height);
  Random random(seed);
  for (auto& value : image.data) value = std::uint8_t(1 + random.below(255));
  return image;
}

// A transfer that shifts by (dx, dy) at inverse depth 0.
Transfer shift(float dx, float dy) { return {{1, 0, dx, 0, 1, dy, 0, 0, 1}, {1, 0, 0}}; }

TEST(Sample, IsBilinearInterpolation) {
  const GreyImage image = random_image(80, 70, 1);
  const Quads quads = quads_of(image);
  const auto carried = std::make_unique<Carried>();
  const std::vector<float> w(kRegion, 0);
  carry(shift(10.3f, 7.8f), 0, 0, w.data(), *carried);
  alignas(64) float floats[kRegion];
  alignas(64) std::int8_t bytes[kRegion];
  sample(quads, *carried, 0.25f, 0, 0, floats);
  sample(quads, *carried, 0.25f, 0, 0, bytes);
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i) {
      const double truth = double(bilinear(image, i + 0.5 + 10.3 + 0.25, j + 0.5 + 7.8)) - 128;
      EXPECT_NEAR(floats[j * kRegionWidth + i], truth, 0.01);
      EXPECT_NEAR(bytes[j * kRegionWidth + i], truth, 0.5 + 255 / 128.0);  // rounding; position to 1/128 px
    }
}

TEST(Sample, OutsideThereIsNothing) {
  const GreyImage image = random_image(60, 60, 2);
  const Quads quads = quads_of(image);
  const auto carried = std::make_unique<Carried>();
  const std::vector<float> w(kRegion, 0);
  carry(shift(-10, 30), 0, 0, w.data(), *carried);
  alignas(64) float floats[kRegion];
  alignas(64) std::int8_t bytes[kRegion];
  sample(quads, *carried, 0, 0, 0, floats);
  sample(quads, *carried, 0, 0, 0, bytes);
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i) {
      const bool inside = i - 10 >= 1 && j + 30 >= 1 && i - 10 < 59 && j + 30 < 59;
      if (inside) {
        EXPECT_FALSE(std::isnan(floats[j * kRegionWidth + i]));
      }
      if (i - 10 < 0 || j + 30 >= 60) {
        EXPECT_TRUE(std::isnan(floats[j * kRegionWidth + i]));
        EXPECT_EQ(bytes[j * kRegionWidth + i], -128);
      }
    }
}

TEST(Census, CountsPairsThatChangeTheirOrder) {
  alignas(64) std::int8_t a[kRegion], b[kRegion];
  Random random(3);
  for (auto& v : a) v = std::int8_t(int(random.below(255)) - 127);
  for (auto& v : b) v = std::int8_t(int(random.below(255)) - 127);
  alignas(64) std::uint8_t planes[kCensusBits * kCellPixels], distance[kCellPixels];
  census(a, planes);
  census_distance(b, planes, distance);
  for (int y = 0; y < kCell; ++y)
    for (int x = 0; x < kCell; ++x) {
      const int centre = (y + kRadius) * kRegionWidth + x + kRadius;
      int twice = 0;
      for (int dy = -kRadius; dy <= kRadius; ++dy)
        for (int dx = -kRadius; dx <= kRadius; ++dx) {
          const int off = dy * kRegionWidth + dx;
          // equal values do not rise, whichever comes first: count each pair in the order the kernel has
          if (dy < 0 || (dy == 0 && dx < 0))
            twice += (a[centre + off] < a[centre - off]) != (b[centre + off] < b[centre - off]);
        }
      EXPECT_EQ(int(distance[y * kCell + x]), twice);
    }
  census_distance(a, planes, distance);
  EXPECT_EQ(*std::max_element(distance, distance + kCellPixels), 0);
}

TEST(Cost, IsTheMeanOfTheBetterHalf) {
  const auto smallest = std::make_unique<Smallest>();
  const auto cost_of = [&](std::vector<std::uint8_t> distances) {
    clear(*smallest);
    alignas(64) std::uint8_t plane[kCellPixels], result[kCellPixels];
    for (const std::uint8_t d : distances) {
      std::fill(plane, plane + kCellPixels, d);
      add(plane, *smallest);
    }
    cost(*smallest, result);
    return int(result[kCellPixels - 1]);
  };
  EXPECT_EQ(cost_of({}), kCostOfChance);
  EXPECT_EQ(cost_of({255, 255}), kCostOfChance);
  EXPECT_EQ(cost_of({5}), 5 * kCostPerBit);
  EXPECT_EQ(cost_of({9, 255, 5}), 7 * kCostPerBit);
  EXPECT_EQ(cost_of({20, 9, 5, 21}), 7 * kCostPerBit);
  EXPECT_EQ(cost_of({20, 9, 5, 4, 22, 23}), 6 * kCostPerBit);
}

TEST(Correlate, IsTheCorrelationCoefficient) {
  alignas(64) float a[kRegion], b[kRegion], result[kCellPixels];
  Random random(4);
  for (auto& v : a) v = float(random.uniform(-100, 100));
  for (int i = 0; i < kRegion; ++i) b[i] = 0.5f * a[i] + float(random.uniform(-60, 60)) + 20;
  const auto statistics = std::make_unique<WindowStatistics>();
  window_statistics(a, *statistics);
  correlate(a, *statistics, b, result);
  const double n = (2 * kRadius + 1) * (2 * kRadius + 1);
  for (int y = 0; y < kCell; y += 5)
    for (int x = 0; x < kCell; x += 3) {
      double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
      for (int j = 0; j <= 2 * kRadius; ++j)
        for (int i = 0; i <= 2 * kRadius; ++i) {
          const double p = double(a[(y + j) * kRegionWidth + x + i]), q = double(b[(y + j) * kRegionWidth + x + i]);
          sa += p, sb += q, saa += p * p, sbb += q * q, sab += p * q;
        }
      const double truth = (sab - sa * sb / n) / std::sqrt((saa - sa * sa / n) * (sbb - sb * sb / n));
      EXPECT_NEAR(result[y * kCell + x], truth, 1e-4);
    }
}

// The same recursion, written plainly for an image whose labels are the same everywhere.
std::vector<int> plain_sums(const std::vector<int>& costs, int width, int height, int labels, int small, int large) {
  std::vector<int> sums(costs.size(), 0);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (!dx && !dy) continue;
      std::vector<int> path(costs);
      for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
          const int y = dy < 0 || (dy == 0 && dx < 0) ? height - 1 - j : j,
                    x = dy < 0 || (dy == 0 && dx < 0) ? width - 1 - i : i;
          const int px = x - dx, py = y - dy;
          int* here = path.data() + (y * width + x) * labels;
          if (px >= 0 && py >= 0 && px < width && py < height) {
            const int* before = path.data() + (py * width + px) * labels;
            const int least = *std::min_element(before, before + labels);
            for (int k = 0; k < labels; ++k) {
              int best = std::min(before[k], least + large);
              if (k > 0) best = std::min(best, before[k - 1] + small);
              if (k + 1 < labels) best = std::min(best, before[k + 1] + small);
              here[k] += best - least;
            }
          }
          for (int k = 0; k < labels; ++k) sums[std::size_t((y * width + x) * labels + k)] += here[k];
        }
    }
  return sums;
}

TEST(Aggregate, EqualsThePlainRecursionAlsoAcrossCells) {
  const int width = 70, height = 45;
  Labels labels = labels_around_plane(width, height, 0.01f, 1, 0, 0, 0, 20);
  // the same hypotheses, but every other cell starts three labels lower and its plane three steps higher
  for (std::size_t i = 0; i < labels.cells.size(); i += 2) {
    labels.cells[i].first -= 3;
    labels.cells[i].at_corner += 0.03f;
  }
  const int count = labels.cells[0].labels;
  Volume volume = volume_for(labels, {0, 0, labels.columns, labels.rows});
  std::vector<int> costs(std::size_t(width * height * count));
  Random random(5);
  const auto index_of = [&](int x, int y) {
    const Cell& cell = labels.cell(x / kCell, y / kCell);
    return volume.offset(x / kCell, y / kCell) +
           std::size_t(((y - cell.top) * kCell + x - cell.left) * cell.stride + kGuard);
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < count; ++k)
        volume.costs[index_of(x, y) + std::size_t(k)] =
            std::uint8_t(costs[std::size_t((y * width + x) * count + k)] = int(random.below(140)));
  const GreyImage flat(width, height, 1, 100);
  Smoothness smoothness{GreyImage(width, height, 1, 8), {}};
  smoothness.large.fill(60);
  const auto sums = aggregate(labels, volume, flat, smoothness, [] { return false; });
  const auto truth = plain_sums(costs, width, height, count, 8, 60);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < count; ++k)
        ASSERT_EQ(int(sums[index_of(x, y) + std::size_t(k)]), truth[std::size_t((y * width + x) * count + k)])
            << x << " " << y << " " << k;
}

TEST(Winner, LiesBetweenLabelsWhereTheParabolaSays) {
  std::vector<std::uint16_t> sums(16, 1000);
  for (int k = 0; k < 10; ++k) sums[std::size_t(k + kGuard)] = std::uint16_t(100 + 10 * (k - 4.3) * (k - 4.3));
  EXPECT_NEAR(winner(sums.data(), 10), 4.3, 0.05);  // sums are whole numbers
}

TEST(FirstLeast, IsTheFirstOfTheLeast) {
  Random random(31);
  for (const int labels : {1, 2, 14, 15, 16, 40, 190}) {
    std::vector<std::uint16_t> values(std::size_t((labels + 2 + 15) / 16 * 16));
    for (int turn = 0; turn < 20; ++turn) {
      for (auto& value : values) value = turn ? std::uint16_t(random.below(9)) : std::uint16_t(0xFFFF);
      values.front() = 0;
      values[std::size_t(labels + 1)] = 0;
      EXPECT_EQ(first_least(values.data(), 1, labels + 1),
                std::min_element(values.begin() + 1, values.begin() + 1 + labels) - values.begin());
    }
  }
}

// Random values with holes.
FloatImage random_surface(int width, int height, double holes, std::uint64_t seed) {
  FloatImage surface(width, height);
  Random random(seed);
  for (auto& value : surface.data) value = random.uniform(0, 1) < holes ? NAN : float(random.uniform(0, 1));
  return surface;
}

// Those that are known of the square around a pixel.
std::vector<float> known_around(const FloatImage& surface, int x, int y, int reach) {
  std::vector<float> values;
  for (int v = std::max(y - reach, 0); v <= std::min(y + reach, surface.height - 1); ++v)
    for (int u = std::max(x - reach, 0); u <= std::min(x + reach, surface.width - 1); ++u)
      if (!std::isnan(surface.at(u, v))) values.push_back(surface.at(u, v));
  return values;
}

TEST(Median3, IsThatOfWhatIsKnown) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {40, 30}})
    for (const double holes : {0.0, 0.5, 0.9}) {
      const FloatImage surface = random_surface(width, height, holes, 5), found = median3(surface);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          std::vector<float> values = known_around(surface, x, y, 1);
          std::sort(values.begin(), values.end());
          if (values.empty()) {
            EXPECT_TRUE(std::isnan(found.at(x, y)));
          } else {
            EXPECT_EQ(found.at(x, y), values[values.size() / 2]) << x << ' ' << y;
          }
        }
    }
}

TEST(SmoothedWithin, IsTheMeanOfWhatIsAlike) {
  constexpr float kReach = 0.3f;
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {40, 30}}) {
    const FloatImage surface = random_surface(width, height, 0.3, 6), found = smoothed_within(surface, kReach);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const float middle = surface.at(x, y);
        if (std::isnan(middle)) {
          EXPECT_TRUE(std::isnan(found.at(x, y)));
          continue;
        }
        double sum = 0;
        int count = 0;
        for (const float value : known_around(surface, x, y, 2))
          if (std::abs(value - middle) <= kReach) sum += double(value), ++count;
        EXPECT_NEAR(double(found.at(x, y)), sum / count, 1e-5);
      }
  }
}

Level level_of(const GreyImage& image) {
  Level level;
  level.image = &image;
  level.focal_px = 100;
  level.cx = 0.5f * float(image.width);
  level.cy = 0.5f * float(image.height);
  level.step = 0.002f;
  return level;
}

// A view `aside` to the right whose image, of chance, shows the whole reference at depths around 10.
View view_of_chance(float aside, std::uint64_t seed) {
  View view{quads_of(random_image(160, 90, seed)), shift(30 + 10 * aside, 12), {aside, 0, 0}};
  view.transfer.b = {-100 * aside, 0, 0};
  return view;
}

FloatImage surface_by(const std::vector<View>& views) {
  const GreyImage image = random_image(64, 64, 11);
  Level level = level_of(image);
  level.views = views;
  SharedBudget costs(usual_bytes_to_match());
  return match_level(level, labels_around_plane(64, 64, level.step, 0.1f, 0, 0, -8, 8), costs, {});
}

// Rays meet at 0.1 rad, twice, and at 0.7 rad.
TEST(MatchLevel, ViewsAtWideAnglesHaveNoSayWhereTwoOthersSee) {
  const View near = view_of_chance(1, 12), other = view_of_chance(-1, 13), wide = view_of_chance(8, 14);
  EXPECT_EQ(surface_by({near, other, wide}).data, surface_by({near, other}).data);
  EXPECT_NE(surface_by({near, wide}).data, surface_by({near}).data);
}

// A strip of five tiles, matched in three threads.
TEST(MatchLevel, TilesThatDoNotFitIntoTheRoomWaitAndComeOutTheSame) {
  constexpr int kWidth = 3200, kHeight = 40;
  const GreyImage image = random_image(kWidth, kHeight, 11);
  Level level = level_of(image);
  level.views = {view_of_chance(1, 12), view_of_chance(-1, 13)};
  const Labels labels = labels_around_plane(kWidth, kHeight, level.step, 0.1f, 0, 0, -8, 8);
  const std::size_t all = bytes_to_match(labels, {0, 0, labels.columns, labels.rows});
  collinea::Run run;
  run.threads = 3;
  SharedBudget one(1), many(all * 2);
  const FloatImage waited = match_level(level, labels, one, run), free = match_level(level, labels, many, run);
  EXPECT_LT(one.most_in_use(), all / 3);
  EXPECT_GT(one.most_in_use(), all / 6);
  EXPECT_EQ(0, std::memcmp(waited.data.data(), free.data.data(), free.data.size() * sizeof(float)));
}

// A patch of nine pixels, 0.5 above the rest.
TEST(RemoveSpeckles, StandardDeviationsJoinWhatTheyCannotTellApart) {
  FloatImage surface(30, 20, 1, 1);
  for (int y = 5; y < 8; ++y)
    for (int x = 10; x < 13; ++x) surface.at(x, y) = 1.5f;
  FloatImage exact = surface, uncertain = surface, certain = surface;
  remove_speckles(exact, 0.1f, 40);
  EXPECT_TRUE(std::isnan(exact.at(11, 6)));
  EXPECT_EQ(exact.at(9, 6), 1);
  const FloatImage large(30, 20, 1, 0.11f), small(30, 20, 1, 0.09f);  // 0.1 + 2 (0.11 + 0.11) = 0.54; 0.46
  remove_speckles(uncertain, 0.1f, 40, &large);
  EXPECT_EQ(uncertain.data, surface.data);
  remove_speckles(certain, 0.1f, 40, &small);
  EXPECT_TRUE(std::isnan(certain.at(11, 6)));
}

// Every patch filled in turn, pixel by pixel.
FloatImage without_speckles(const FloatImage& surface, float reach, int min_pixels, const FloatImage* sigma) {
  FloatImage result = surface;
  std::vector<char> seen(surface.data.size(), 0);
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first]) continue;
    std::vector<std::size_t> patch{first};
    seen[first] = 1;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const int x = int(patch[i]) % surface.width, y = int(patch[i]) / surface.width;
      for (const auto& [u, v] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
        if (u < 0 || v < 0 || u >= surface.width || v >= surface.height) continue;
        const float more = sigma ? 2 * (sigma->at(x, y) + sigma->at(u, v)) : 0;
        const std::size_t at = std::size_t(v * surface.width + u);
        if (seen[at] || !(std::abs(surface.at(x, y) - surface.at(u, v)) <= reach + more)) continue;
        seen[at] = 1;
        patch.push_back(at);
      }
    }
    if (int(patch.size()) < min_pixels)
      for (const std::size_t at : patch) result.data[at] = NAN;
  }
  return result;
}

TEST(RemoveSpeckles, EqualsFillingPatches) {
  Random random(12);
  for (const int width : {1, 63, 64, 65, 150})
    for (const double reach : {1.1, 1.5, 2.1}) {  // values 0 to 4 as well: few large patches, and many small ones
      FloatImage surface(width, 40), sigma(width, 40);
      for (auto& value : surface.data) value = random.below(12) ? float(random.below(5)) : NAN;
      for (auto& value : sigma.data) value = float(random.uniform(0, 0.3));
      for (const FloatImage* known : {static_cast<FloatImage*>(nullptr), &sigma}) {
        FloatImage found = surface;
        remove_speckles(found, float(reach), 20, known);
        const FloatImage plain = without_speckles(surface, float(reach), 20, known);
        for (std::size_t i = 0; i < plain.data.size(); ++i) {
          EXPECT_EQ(std::isnan(found.data[i]), std::isnan(plain.data[i])) << width << ' ' << i;
          if (!std::isnan(plain.data[i])) {
            EXPECT_EQ(found.data[i], surface.data[i]);
          }
        }
      }
    }
}

TEST(TextureAround, IsTheMeanOfTwoDifferences) {
  for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {64, 9}, {90, 40}}) {
    const GreyImage image = random_image(width, height, 5);
    const auto texture = [&](int x, int y) {
      const int own = image.at(x, y), right = image.at(std::min(x + 1, width - 1), y),
                below = image.at(x, std::min(y + 1, height - 1));
      return std::min(std::abs(own - right) + std::abs(own - below), 255);
    };
    const GreyImage found = texture_around(image);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        int sum = 0, count = 0;
        for (int v = std::max(y - 3, 0); v <= std::min(y + 3, height - 1); ++v)
          for (int u = std::max(x - 3, 0); u <= std::min(x + 3, width - 1); ++u, ++count) sum += texture(u, v);
        EXPECT_EQ(int(found.at(x, y)), sum / count) << x << ' ' << y;
      }
  }
  EXPECT_TRUE(texture_around({}).empty());
}

TEST(FillHoles, LeavesValuesAndFillsTheRest) {
  FloatImage raster(33, 21, 1, NAN);
  raster.at(3, 4) = 5;
  raster.at(30, 15) = 9;
  fill_holes(raster);
  EXPECT_EQ(raster.at(3, 4), 5);
  EXPECT_EQ(raster.at(30, 15), 9);
  for (const float value : raster.data) {
    EXPECT_GE(value, 5);
    EXPECT_LE(value, 9);
  }
}

}  // namespace
}  // namespace collinea::dense
