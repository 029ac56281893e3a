// SPDX-License-Identifier: Apache-2.0
// Matching of rectified pairs beside OpenCV's StereoSGBM (MODE_HH, eight directions), on pairs with true disparities.
//
// usage: collinea_bench_stereo [--middlebury FOLDER] [--cost NAME] [--rounds N] [--threads N]
//                              [--only NAME,...] [--alone yes]
// FOLDER holds cones, cloth3 and wood2 (left.png, right.png, disp_left_xN.png, drange.txt). Besides, pairs rendered
// from made-up scenes with exact truth. Both programs get the same images, range and threads, in turns, N rounds.
//   bad        pixels more than 2 px off, of those with truth that were measured [%]
//   left out   pixels with truth that were not measured [%]
//   filled     pixels more than 2 px off when every hole is filled the same way, of all with truth [%]
//   rms        of the errors below 2 px [px]
//   sigma      ours: 95 % bounds that hold the error, of the measured ones that are not bad [%]
//   CPU s      least processor time of the rounds, all threads together;  s: least time on the clock
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <string>
#include <vector>

#include "collinea/dense/stereo.h"
#include "collinea/raster/image_file.h"
#include "collinea/synthetic/render.h"
#include "collinea/synthetic/survey.h"

namespace {

using namespace collinea;
namespace fs = std::filesystem;

constexpr double kBad_px = 2;
const float kNaN = std::numeric_limits<float>::quiet_NaN();

struct Pair {
  std::string name;
  GreyImage left, right;
  DisparityRange range;
  FloatImage truth;      // NaN where unknown
  bool complete = true;  // truth has hidden pixels, too
};

GreyImage readable(GreyImage image) {
  for (auto& grey : image.data) grey = std::max<std::uint8_t>(grey, 1);
  return image;
}

std::optional<Pair> middlebury(const fs::path& folder, int factor) {
  const auto left = read_grey(folder / "left.png"), right = read_grey(folder / "right.png");
  const auto truth = read_grey(folder / ("disp_left_x" + std::to_string(factor) + ".png"));
  if (!left || !right || !truth) return std::nullopt;
  Pair pair{folder.filename().string(), readable(*left), readable(*right), {}, {}};
  std::ifstream range(folder / "drange.txt");
  std::string text;
  while (range >> text) {
    if (text.rfind("dmin=", 0) == 0) pair.range.low = std::stoi(text.substr(5));
    if (text.rfind("dmax=", 0) == 0) pair.range.high = std::stoi(text.substr(5)) - 1;
  }
  pair.truth = FloatImage(truth->width, truth->height, 1, kNaN);
  for (std::size_t i = 0; i < truth->data.size(); ++i)
    if (truth->data[i]) pair.truth.data[i] = float(truth->data[i]) / float(factor);
  return pair;
}

// Two cameras side by side in a made-up world, the first where one of its own images was taken.
std::optional<Pair> rendered(const std::string& name, Truth truth, double base_m, int width, int height) {
  const std::vector<OrientedImage> oriented = oriented_images(truth.block);
  const ImageId left = oriented[0].image, right = oriented[1].image;
  const Camera camera = ideal_camera(0.8 * width, width, height);
  truth.block.cameras.at(truth.block.images.at(left).camera) = camera;
  const Rigid3 pose = pose_of(truth.block, left);
  set_pose(truth.block, right, {pose.rotation, pose.translation - Eigen::Vector3d(base_m, 0, 0)});
  Run run;
  run.threads = 2;
  const RayTable rays(camera, run);
  Pair pair;
  pair.name = name;
  for (const ImageId id : {left, right}) {
    const auto image = render(truth, id, rays, run);
    if (!image) return std::nullopt;
    GreyImage grey(width, height);
    for (std::size_t i = 0; i < grey.data.size(); ++i)
      grey.data[i] = std::uint8_t(
          (299 * image->data[3 * i] + 587 * image->data[3 * i + 1] + 114 * image->data[3 * i + 2] + 500) / 1000);
    (id == left ? pair.left : pair.right) = readable(grey);
  }
  pair.truth = FloatImage(width, height, 1, kNaN);
  float largest = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (const auto hit = shown_at(truth, left, {x + 0.5, y + 0.5})) {
        pair.truth.at(x, y) = float(camera.focal_px() * base_m / (pose * hit->point).z());
        largest = std::max(largest, pair.truth.at(x, y));
      }
  pair.range = {0, (int(largest * 1.1) / 16 + 1) * 16 - 1};
  return pair;
}

struct Timed {
  DisparityMap map;
  double cpu_s = 1e9, clock_s = 1e9;
};

void timed(Timed& result, const std::function<DisparityMap()>& match) {
  const auto clock = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  DisparityMap map = match();
  result.cpu_s = std::min(result.cpu_s, double(std::clock() - cpu) / CLOCKS_PER_SEC);
  result.clock_s =
      std::min(result.clock_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - clock).count());
  result.map = std::move(map);
}

DisparityMap by_opencv(const Pair& pair) {
  constexpr int kBlock = 5;  // the example of its documentation
  const cv::Mat left(pair.left.height, pair.left.width, CV_8U, const_cast<std::uint8_t*>(pair.left.data.data()));
  const cv::Mat right(pair.right.height, pair.right.width, CV_8U, const_cast<std::uint8_t*>(pair.right.data.data()));
  const int labels = (pair.range.high - pair.range.low + 16) / 16 * 16;
  const auto matcher = cv::StereoSGBM::create(pair.range.low, labels, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock,
                                              1, 63, 10, 100, 2, cv::StereoSGBM::MODE_HH);
  cv::Mat found;
  matcher->compute(left, right, found);
  FloatImage disparity(pair.left.width, pair.left.height, 1, kNaN);
  for (int y = 0; y < found.rows; ++y)
    for (int x = 0; x < found.cols; ++x)
      if (const int value = found.at<short>(y, x); value > (pair.range.low - 1) * 16)
        disparity.at(x, y) = float(value) / 16;
  return {disparity, {}};
}

void print(const Pair& pair, const std::string& who, const Timed& result) {
  long truth = 0, measured = 0, bad = 0, good = 0, within = 0, bad_filled = 0;
  double squares = 0;
  FloatImage filled = result.map.disparity;
  fill_disparities(filled);
  for (std::size_t i = 0; i < pair.truth.data.size(); ++i) {
    if (std::isnan(pair.truth.data[i])) continue;
    ++truth;
    bad_filled += !(std::abs(filled.data[i] - pair.truth.data[i]) <= kBad_px);
    const double off = std::abs(result.map.disparity.data[i] - pair.truth.data[i]);
    if (std::isnan(off)) continue;
    ++measured;
    if (off > kBad_px) {
      ++bad;
      continue;
    }
    ++good;
    squares += off * off;
    if (!result.map.sigma.empty()) within += off <= 1.96 * result.map.sigma.data[i];
  }
  const auto percent = [](long part, long whole) { return whole ? 100.0 * double(part) / double(whole) : 0; };
  fmt::print("| {} | {} | {:.2f} | {:.1f} | {:.2f} | {:.2f} | {} | {:.3f} | {:.3f} |\n", pair.name, who,
             percent(bad, measured), percent(truth - measured, truth), percent(bad_filled, truth),
             good ? std::sqrt(squares / double(good)) : 0.0,
             result.map.sigma.empty() ? "-" : fmt::format("{:.0f}", percent(within, good)), result.cpu_s,
             result.clock_s);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  fs::path folder = "../shared/data/middlebury_stereo";
  std::string only;
  int rounds = 5;
  bool alone = false;
  Run run;
  StereoOptions options;
  for (int i = 1; i < argc; i += 2) {
    const std::string flag = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
    if (flag == "--middlebury" && !value.empty()) {
      folder = value;
    } else if (flag == "--cost" && from_word<StereoCost>(value)) {
      options.cost = *from_word<StereoCost>(value);
    } else if (flag == "--rounds" && std::atoi(value.c_str()) > 0) {
      rounds = std::atoi(value.c_str());
    } else if (flag == "--threads" && std::atoi(value.c_str()) > 0) {
      run.threads = std::atoi(value.c_str());
    } else if (flag == "--only" && !value.empty()) {
      only = value;
    } else if (flag == "--alone" && (value == "yes" || value == "no")) {
      alone = value == "yes";
    } else {
      fmt::print(stderr, "cannot use {} {}\n", flag, value);
      return 2;
    }
  }
  cv::setNumThreads(run.threads);
  std::vector<std::function<std::optional<Pair>()>> pairs;
  const auto wanted = [&](const std::string& name) { return only.empty() || only.find(name) != std::string::npos; };
  for (const auto& [name, factor] : {std::pair{"cones", 4}, {"cloth3", 2}, {"wood2", 2}})
    if (wanted(name)) pairs.push_back([=] { return middlebury(folder / name, factor); });
  if (wanted("village"))
    pairs.push_back([] {
      auto truth = make_survey({.gsd_m = 0.1, .camera = {.width_px = 1024, .height_px = 768}});
      return truth ? rendered("village, rendered", std::move(*truth), 12, 1024, 768) : std::nullopt;
    });
  if (wanted("facade"))
    pairs.push_back([] {
      auto truth = make_facade({.camera = {.width_px = 1024, .height_px = 768}});
      return truth ? rendered("facade, rendered", std::move(*truth), 1.2, 1024, 768) : std::nullopt;
    });
  fmt::print(
      "| pair | by | bad % | left out % | filled % | rms px | sigma % | CPU s | s "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& make : pairs) {
    const auto pair = make();
    if (!pair) continue;
    Timed ours, theirs;
    for (int i = 0; i < rounds; ++i) {
      if (!alone) timed(theirs, [&] { return by_opencv(*pair); });
      timed(ours, [&] {
        auto found = match_pair(pair->left, pair->right, pair->range, options, run);
        if (!found) {
          fmt::print(stderr, "{}: {}\n", pair->name, found.error().message);
          std::exit(1);
        }
        return std::move(*found);
      });
    }
    fmt::print("{} x {}, {} disparities\n", pair->left.width, pair->left.height,
               pair->range.high - pair->range.low + 1);
    if (!alone) print(*pair, "OpenCV SGBM HH", theirs);
    print(*pair, "collinea", ours);
    if (!alone)
      fmt::print("times as fast: {:.1f} in processor time, {:.1f} on the clock\n", theirs.cpu_s / ours.cpu_s,
                 theirs.clock_s / ours.clock_s);
  }
}
