// SPDX-License-Identifier: Apache-2.0
// Corner maps and points beside OpenCV's, on one thread: time, and whether the maps are the same. Of a folder with
// img1.png ... img6.png and H1to2p ... H1to6p (Oxford's "graf"): repeatability of all operators.
//
// usage: collinea_bench_interest IMAGE [REPEATS]
//        collinea_bench_interest FOLDER [COUNT]
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "collinea/feature/interest.h"
#include "collinea/feature/repeatability.h"

namespace {

using collinea::FloatImage;
using collinea::GreyImage;
using collinea::InterestOperator;
using collinea::InterestOptions;

// The shortest of some runs [s].
template <class Work>
double seconds(int repeats, const Work& work) {
  double best = 1e9;
  for (int i = 0; i < repeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

// The correlation of two maps, away from the border.
double correlation(const FloatImage& a, const cv::Mat& b) {
  constexpr int kBorder = 16;
  double n = 0, sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
  for (int y = kBorder; y < a.height - kBorder; ++y)
    for (int x = kBorder; x < a.width - kBorder; ++x) {
      const double u = a.at(x, y), v = std::max(0.0f, b.at<float>(y, x));
      n += 1, sa += u, sb += v, aa += u * u, bb += v * v, ab += u * v;
    }
  return (n * ab - sa * sb) / std::sqrt((n * aa - sa * sa) * (n * bb - sb * sb));
}

GreyImage grey_of(const cv::Mat& theirs) {
  GreyImage image(theirs.cols, theirs.rows);
  for (int y = 0; y < theirs.rows; ++y) std::copy_n(theirs.ptr(y), theirs.cols, image.row(y));
  return image;
}

// Homographies of files count pixels from the middle of the first; here its corner is 0.
Eigen::Matrix3d homography_in(const std::string& file) {
  Eigen::Matrix3d h, half = Eigen::Matrix3d::Identity();
  std::ifstream in(file);
  for (int i = 0; i < 9; ++i) in >> h(i / 3, i % 3);
  half.topRightCorner<2, 1>().setConstant(0.5);
  return half * h * half.inverse();
}

int repeatability_table(const std::string& folder, int count) {
  constexpr double kTolerance_px = 1.5, kBorder_px = 16;
  std::vector<GreyImage> images;
  for (int k = 1; k <= 6; ++k)
    images.push_back(grey_of(cv::imread(fmt::format("{}/img{}.png", folder, k), cv::IMREAD_GRAYSCALE)));
  fmt::print("{} points an image, found again within {} px: share, and RMS distance [px]\n\n", count, kTolerance_px);
  fmt::print("| operator | 1-2 | 1-3 | 1-4 | 1-5 | 1-6 |\n|---|---|---|---|---|---|\n");
  for (const auto& [method, word, meaning] : words(InterestOperator{})) {
    const InterestOptions options{.method = method, .relative_threshold = 1e-4, .max_points = count};
    const auto first = collinea::find_interest_points(images[0], options).points;
    fmt::print("| {} |", word);
    for (std::size_t k = 1; k < images.size(); ++k) {
      const auto there = collinea::find_interest_points(images[k], options).points;
      const auto r = collinea::repeatability(
          first, there, homography_in(fmt::format("{}/H1to{}p", folder, k + 1)),
          {images[0].width, images[0].height, images[k].width, images[k].height, kBorder_px}, kTolerance_px);
      fmt::print(" {:.2f}, {:.2f} |", r.rate(), r.rms_px);
    }
    fmt::print("\n");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: collinea_bench_interest IMAGE [REPEATS] | FOLDER [COUNT]\n");
    return 2;
  }
  if (std::filesystem::is_directory(argv[1])) return repeatability_table(argv[1], argc > 2 ? std::atoi(argv[2]) : 1000);
  cv::setNumThreads(1);
  const int repeats = argc > 2 ? std::atoi(argv[2]) : 5;
  const cv::Mat theirs = cv::imread(argv[1], cv::IMREAD_GRAYSCALE);
  if (theirs.empty()) {
    fmt::print(stderr, "{}: no image\n", argv[1]);
    return 1;
  }
  const GreyImage image = grey_of(theirs);
  const double megapixels = 1e-6 * theirs.cols * theirs.rows;
  fmt::print("{} x {}: {:.1f} megapixels, one thread, the shortest of {} runs\n\n", theirs.cols, theirs.rows,
             megapixels, repeats);
  fmt::print("| map | ms | megapixels / s | points | ms |\n|---|---|---|---|---|\n");
  for (const auto& [method, word, meaning] : words(InterestOperator{})) {
    const InterestOptions options{.method = method};
    FloatImage map;
    const double of_map = seconds(repeats, [&, m = method] { map = interest_map(image, options); });
    std::size_t points = 0;
    const double of_points =
        seconds(1, [&] { points = collinea::find_interest_points(image, map, options).points.size(); });
    fmt::print("| {} | {:.0f} | {:.0f} | {} | {:.0f} |\n", word, 1000 * of_map, megapixels / of_map, points,
               1000 * of_points);
  }
  // OpenCV sums over a box; a box of 5 has the variance of a Gaussian of 1.41.
  cv::Mat map;
  const double harris = seconds(repeats, [&] { cv::cornerHarris(theirs, map, 5, 3, 0.04); });
  const double same = correlation(interest_map(image, {.method = InterestOperator::kHarris, .sigma_px = 1.41}), map);
  fmt::print("| OpenCV cornerHarris (Sobel, box 5) | {:.0f} | {:.0f} | | |\n", 1000 * harris, megapixels / harris);
  const double eigen = seconds(repeats, [&] { cv::cornerMinEigenVal(theirs, map, 5, 3); });
  fmt::print("| OpenCV cornerMinEigenVal (Sobel, box 5) | {:.0f} | {:.0f} | | |\n", 1000 * eigen, megapixels / eigen);
  fmt::print("\ncorrelation of both Harris maps {:.3f}\n", same);
  return 0;
}
