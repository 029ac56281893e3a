// SPDX-License-Identifier: Apache-2.0
// Our features beside OpenCV's SIFT on images of a plane with known homographies (Mikolajczyk et al., IJCV 2005).
//
// usage: collinea_bench_graf FOLDER|PICTURE [COUNT ...]
// FOLDER holds img1.png ... img6.png and H1to2p ... H1to6p. A PICTURE is warped by homographies of our own instead, so
// that the truth is exact. Both detectors give the same number of features: COUNT, or, where it is 0 or more than there
// are, as many in each image as OpenCV's SIFT finds there without a limit. Default: 1000, 2000 and 0. Ours twice:
// with the evenness that is the default, and the strongest alone, as OpenCV's.
//   covered        regions of the first image (16 features each on an average) with at least 4 features
//   repeatability  features of the first image, in the part that the other sees, with a feature of the other within
//                  2.5 px and half an octave, one to one, over the smaller number of features in the common part
//   correct        matches (nearest both ways, ratio 0.8 both ways) within 5 px of the homography
//                  (2.5 px where it is exact)
//   inlier ratio   correct over all matches
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "collinea/feature/sift.h"
#include "collinea/match/descriptors.h"

namespace {

using collinea::Match;

constexpr double kSamePosition_px = 2.5, kSameScale_octaves = 0.5, kRatio = 0.8;
// The homographies of graf are off by 3 px in parts (the matches of either detector agree on that between 1 and 2).
constexpr double kCorrectMeasured_px = 5, kCorrectExact_px = 2.5;
// Fewer correct matches of both say nothing about either.
constexpr int kTooFew = 5;

struct Spot {
  Eigen::Vector2d position_px;  // the centre of the first pixel is (0, 0), as in the homographies
  double scale_px;
};

struct Found {
  std::vector<Spot> spots;
  collinea::Features ours;  // of one detector
  cv::Mat theirs;           // or of the other
};

Found by_collinea(const cv::Mat& raster, int count, double evenness) {
  collinea::GreyImage image(raster.cols, raster.rows);
  for (int y = 0; y < raster.rows; ++y) std::copy_n(raster.ptr(y), raster.cols, image.row(y));
  Found found;
  found.ours = collinea::detect_sift(image, {.max_features = count, .evenness = evenness});
  for (const auto& k : found.ours.keypoints) found.spots.push_back({{k.x - 0.5, k.y - 0.5}, k.scale_px});
  return found;
}

Found by_opencv(const cv::Mat& image, int count) {
  Found found;
  std::vector<cv::KeyPoint> keypoints;
  const auto sift = cv::SIFT::create(count);
  sift->detectAndCompute(image, {}, keypoints, found.theirs);
  const int all = static_cast<int>(keypoints.size()),
            kept = count > 0 ? std::min(count, all) : all;  // it may give more
  std::vector<int> order(keypoints.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](int i) { return keypoints[static_cast<std::size_t>(i)].response; });
  cv::Mat descriptors(kept, found.theirs.cols, found.theirs.type());
  for (int i = 0; i < kept; ++i) {
    const auto& k = keypoints[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])];
    found.spots.push_back({{k.pt.x, k.pt.y}, k.size / 2});
    found.theirs.row(order[static_cast<std::size_t>(i)]).copyTo(descriptors.row(i));
  }
  found.theirs = descriptors;
  return found;
}

std::vector<int> distinct_nearest(const cv::Mat& a, const cv::Mat& b) {
  std::vector<std::vector<cv::DMatch>> two;
  cv::BFMatcher(cv::NORM_L2).knnMatch(a, b, two, 2);
  std::vector<int> nearest(two.size(), -1);
  for (std::size_t i = 0; i < two.size(); ++i)
    if (two[i].size() == 2 && two[i][0].distance < kRatio * two[i][1].distance) nearest[i] = two[i][0].trainIdx;
  return nearest;
}

std::vector<Match> matches_of(const Found& a, const Found& b) {
  if (a.theirs.empty())
    return collinea::match_descriptors(a.ours.descriptors, b.ours.descriptors, {.max_ratio = kRatio});
  const std::vector<int> of_a = distinct_nearest(a.theirs, b.theirs), of_b = distinct_nearest(b.theirs, a.theirs);
  std::vector<Match> matches;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (of_a[i] >= 0 && of_b[static_cast<std::size_t>(of_a[i])] == static_cast<int>(i))
      matches.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(of_a[i]));
  return matches;
}

double covered(const std::vector<Spot>& spots, const cv::Mat& image) {
  constexpr double kMean = 16;
  constexpr int kLeast = 4;
  const double side_px =
      std::sqrt(kMean * image.cols * image.rows / static_cast<double>(std::max<std::size_t>(1, spots.size())));
  const int columns = std::max(1, static_cast<int>(std::lround(image.cols / side_px)));
  const int rows = std::max(1, static_cast<int>(std::lround(image.rows / side_px)));
  std::vector<int> count(static_cast<std::size_t>(columns * rows));
  for (const Spot& s : spots) {
    const int column = std::clamp(static_cast<int>(s.position_px.x() * columns / image.cols), 0, columns - 1);
    const int row = std::clamp(static_cast<int>(s.position_px.y() * rows / image.rows), 0, rows - 1);
    ++count[static_cast<std::size_t>(row * columns + column)];
  }
  return static_cast<double>(std::ranges::count_if(count, [](int n) { return n >= kLeast; })) / (columns * rows);
}

Eigen::Vector2d mapped(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  return (h * p.homogeneous()).hnormalized();
}

// How much longer a short distance is after the mapping.
double enlargement(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  const Eigen::Vector2d at = mapped(h, p), right = mapped(h, p + Eigen::Vector2d(1, 0)),
                        down = mapped(h, p + Eigen::Vector2d(0, 1));
  Eigen::Matrix2d jacobian;
  jacobian << right - at, down - at;
  return std::sqrt(std::abs(jacobian.determinant()));
}

// Spots of a where b looks too, as they appear in b.
std::vector<Spot> common(const std::vector<Spot>& spots, const Eigen::Matrix3d& h, const cv::Mat& other) {
  std::vector<Spot> seen;
  for (const Spot& s : spots) {
    const Eigen::Vector2d p = mapped(h, s.position_px);
    if (p.x() >= 0 && p.y() >= 0 && p.x() <= other.cols - 1 && p.y() <= other.rows - 1)
      seen.push_back({p, s.scale_px * enlargement(h, s.position_px)});
  }
  return seen;
}

double repeatability(const Found& a, const Found& b, const Eigen::Matrix3d& h, const cv::Mat& first,
                     const cv::Mat& second) {
  const std::vector<Spot> from_a = common(a.spots, h, second);
  const std::size_t of_b = common(b.spots, h.inverse(), first).size();
  struct Close {
    double distance_px;
    std::size_t i, j;
    auto operator<=>(const Close&) const = default;
  };
  std::vector<Close> close;
  for (std::size_t i = 0; i < from_a.size(); ++i)
    for (std::size_t j = 0; j < b.spots.size(); ++j) {
      const double distance_px = (from_a[i].position_px - b.spots[j].position_px).norm();
      if (distance_px < kSamePosition_px &&
          std::abs(std::log2(from_a[i].scale_px / b.spots[j].scale_px)) < kSameScale_octaves)
        close.push_back({distance_px, i, j});
    }
  std::ranges::sort(close);
  std::vector<bool> used_a(from_a.size()), used_b(b.spots.size());
  std::size_t count = 0;
  for (const Close& c : close) {
    if (used_a[c.i] || used_b[c.j]) continue;
    used_a[c.i] = used_b[c.j] = true;
    ++count;
  }
  return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, std::min(from_a.size(), of_b)));
}

Eigen::Matrix3d homography_in(const std::string& file) {
  Eigen::Matrix3d h;
  std::ifstream in(file);
  for (int i = 0; i < 9; ++i) in >> h(i / 3, i % 3);
  return h;
}

struct Score {
  double repeatability = 0;
  int correct = 0, all = 0;

  [[nodiscard]] double inlier_ratio() const { return all > 0 ? double(correct) / all : 0; }
};

struct View {
  std::string name;
  cv::Mat image;
  Eigen::Matrix3d from_first;
};

struct Views {
  cv::Mat first;
  std::vector<View> others;
  double correct_px = 0;
};

Score score(const Found& a, const Found& b, const View& view, const Views& views) {
  Score s;
  s.repeatability = repeatability(a, b, view.from_first, views.first, view.image);
  for (const auto& [i, j] : matches_of(a, b)) {
    ++s.all;
    s.correct += (mapped(view.from_first, a.spots[i].position_px) - b.spots[j].position_px).norm() < views.correct_px;
  }
  return s;
}

const char* verdict(const Score& ours, const Score& theirs) {
  if (ours.correct < kTooFew && theirs.correct < kTooFew) return "too few to tell";
  return ours.repeatability >= theirs.repeatability && ours.correct >= theirs.correct &&
                 ours.inlier_ratio() >= theirs.inlier_ratio()
             ? "none lower"
             : "lower";
}

// As many features of both: `count`, or all that OpenCV finds where these are fewer or `count` is 0.
std::pair<Found, Found> features_of(const cv::Mat& image, int count, double evenness) {
  Found theirs = by_opencv(image, count);
  Found ours = by_collinea(image, static_cast<int>(theirs.spots.size()), evenness);
  return {std::move(ours), std::move(theirs)};
}

void compare(const Views& views, int count, double evenness) {
  const auto [ours_first, theirs_first] = features_of(views.first, count, evenness);
  for (const View& view : views.others) {
    const auto [ours_second, theirs_second] = features_of(view.image, count, evenness);
    const Score ours = score(ours_first, ours_second, view, views);
    const Score theirs = score(theirs_first, theirs_second, view, views);
    fmt::print("| {} | {} | {} / {} | {} / {} | {:.2f} / {:.2f} | {:.3f} / {:.3f} | {} / {} | {:.3f} / {:.3f} | {} |\n",
               evenness, view.name, ours_first.spots.size(), theirs_first.spots.size(), ours_second.spots.size(),
               theirs_second.spots.size(), covered(ours_first.spots, views.first),
               covered(theirs_first.spots, views.first), ours.repeatability, theirs.repeatability, ours.correct,
               theirs.correct, ours.inlier_ratio(), theirs.inlier_ratio(), verdict(ours, theirs));
  }
}

Views measured_views(const std::string& folder) {
  const auto image = [&](int k) { return cv::imread(fmt::format("{}/img{}.png", folder, k), cv::IMREAD_GRAYSCALE); };
  Views views{.first = image(1), .others = {}, .correct_px = kCorrectMeasured_px};
  for (int k = 2; k <= 6; ++k)
    views.others.push_back({fmt::format("1-{}", k), image(k), homography_in(fmt::format("{}/H1to{}p", folder, k))});
  return views;
}

// The image as a camera sees it that is turned by `roll_deg` about its axis, comes nearer by `zoom`, and stands at
// `tilt_deg` from the upright to the image, two of its widths away.
Eigen::Matrix3d seen_obliquely(const cv::Mat& image, double tilt_deg, double roll_deg, double zoom) {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  const double focal = 2.0 * image.cols;
  Eigen::Matrix3d to_middle = Eigen::Matrix3d::Identity();
  to_middle.col(2) << -0.5 * image.cols, -0.5 * image.rows, 1;
  const Eigen::Matrix3d turned = (Eigen::AngleAxisd(tilt_deg * kDegree, Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(roll_deg * kDegree, Eigen::Vector3d::UnitZ()))
                                     .toRotationMatrix();
  Eigen::Matrix3d plane = turned;  // columns: the plane's axes, and where its middle is
  plane.col(2) << 0, 0, focal / zoom;
  const Eigen::Matrix3d camera = Eigen::Vector3d(focal, focal, 1).asDiagonal();
  return to_middle.inverse() * camera * plane * to_middle;
}

Views simulated_views(const std::string& file) {
  constexpr double kSize_px = 1000, kSmoothed = 0.8;  // warped at a moderate size, smooth enough for the interpolation
  cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  cv::resize(image, image, {}, kSize_px / image.cols, kSize_px / image.cols, cv::INTER_AREA);
  cv::GaussianBlur(image, image, {}, kSmoothed);
  Views views{.first = image, .others = {}, .correct_px = kCorrectExact_px};
  for (const auto& [tilt_deg, roll_deg, zoom] :
       {std::array{20., 10., 1.}, std::array{40., 0., 1.}, std::array{55., 20., 1.}, std::array{0., 45., 0.6},
        std::array{0., 90., 0.8}, std::array{30., 150., 0.7}}) {
    View view{.name = fmt::format("tilt {}, roll {}, zoom {}", tilt_deg, roll_deg, zoom),
              .image = {},
              .from_first = seen_obliquely(image, tilt_deg, roll_deg, zoom)};
    cv::Mat h(3, 3, CV_64F);
    for (int i = 0; i < 9; ++i) h.at<double>(i / 3, i % 3) = view.from_first(i / 3, i % 3);
    cv::warpPerspective(image, view.image, h, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
    views.others.push_back(view);
  }
  return views;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: collinea_bench_graf FOLDER|PICTURE [COUNT ...]\n");
    return 2;
  }
  std::vector<int> counts;
  for (int i = 2; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (counts.empty()) counts = {1000, 2000, 0};
  fmt::print(
      "| evenness | pictures | features of the first, ours / OpenCV | of the second | covered | repeatability | "
      "correct | inlier ratio | ours |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  const Views views = std::filesystem::is_directory(argv[1]) ? measured_views(argv[1]) : simulated_views(argv[1]);
  for (const int count : counts)
    for (const double evenness : {collinea::SiftOptions{}.evenness, 0.0}) compare(views, count, evenness);
  return 0;
}
