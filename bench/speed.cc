// SPDX-License-Identifier: Apache-2.0
// Speed of the single steps on one thread, beside OpenCV where it has the same operator: one table. Times are those of
// the processor: of many repetitions the median, and the least, which other programs disturb least.
//
// usage: collinea_bench_speed [PART_OF_A_ROW'S_NAME] [REPETITIONS]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "collinea/epipolar/relative_orientation.h"
#include "collinea/feature/interest.h"
#include "collinea/geometry/absolute_orientation.h"
#include "collinea/geometry/closed_similarity.h"
#include "collinea/geometry/rotation.h"
#include "collinea/match/area_matching.h"
#include "collinea/math/random.h"
#include "collinea/orient/space_resection.h"

#ifdef COLLINEA_BENCH_OPENCV
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#endif

namespace {

using namespace collinea;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Work = std::function<void()>;

constexpr int kPoints = 1000;
constexpr int kImageSide_px = 2048;
constexpr int kTemplate_px = 21, kSearch_px = 201;

struct Times {
  double least_ms = 0, median_ms = 0;
};

double now_ms() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * double(time.tv_sec) + 1e-6 * double(time.tv_nsec);
}

Times times_of(const Work& work, int repetitions) {
  work();  // memory and caches
  std::vector<double> all;
  for (int i = 0; i < repetitions; ++i) {
    const double begin = now_ms();
    work();
    all.push_back(now_ms() - begin);
  }
  std::sort(all.begin(), all.end());
  return {all.front(), all[all.size() / 2]};
}

struct Row {
  std::string name, theirs_name;
  Work ours, theirs;      // theirs: nothing where there is no such operator
  double megapixels = 0;  // of a map
  double target = 0;      // ms, or megapixels a second; 0: none
};

Vector3d random_vector(Random& random, double size) {
  return {size * random.normal(), size * random.normal(), size * random.normal()};
}

Eigen::Matrix3d random_covariance(Random& random) {
  Eigen::Matrix3d root;
  for (int i = 0; i < 9; ++i) root(i / 3, i % 3) = random.normal();
  return 0.001 * (0.3 * root * root.transpose() + 0.5 * Eigen::Matrix3d::Identity());
}

// A model with errors and its control; of alike points the closed form is the answer, of others it is a start.
std::vector<AbsoluteControl> control(bool are_alike) {
  Random random(1), other(5);
  const Similarity3 truth{1.7, rotation_by({0.1, -0.2, 2}), {100, 200, 300}};
  std::vector<AbsoluteControl> pairs;
  for (int i = 0; i < kPoints; ++i) {
    AbsoluteControl pair;
    pair.in_model = random_vector(random, 100);
    pair.in_ground = truth * pair.in_model + random_vector(random, 0.03);
    pair.in_model += random_vector(random, 0.05);
    pair.model_covariance = 0.0025 * Eigen::Matrix3d::Identity();
    pair.ground_covariance = 0.0009 * Eigen::Matrix3d::Identity();
    if (!are_alike) pair.model_covariance = random_covariance(other), pair.ground_covariance = random_covariance(other);
    pairs.push_back(pair);
  }
  return pairs;
}

// A vertical photograph of ground with relief.
struct Photograph {
  Camera camera = ideal_camera(4000, 4000, 3000);
  Rigid3 pose, start;
  std::vector<ResectionMark> marks;
  std::vector<ResectionPoint> points;

  explicit Photograph(double sigma_m) {
    Random random(2);
    pose.rotation = cam_from_world({2, -3, 60});
    pose.translation = -(pose.rotation * Vector3d(1, -2, 100));
    start = Rigid3{rotation_by({0.01, -0.01, 0.02}), {1, -1, 1}} * pose;
    for (int i = 0; i < kPoints; ++i) {
      const Vector3d truth(20 * random.normal(), 15 * random.normal(), 4 * random.normal());
      const Vector2d pixel = *project(camera, pose * truth) + 0.7 * Vector2d(random.normal(), random.normal());
      marks.push_back({0, std::size_t(i), pixel, 0.7});
      points.push_back({truth + random_vector(random, sigma_m), Vector3d::Constant(sigma_m)});
    }
  }
};

// Two vertical photographs with a base of a fifth of the distance's.
std::vector<PairPoint> pair_points() {
  constexpr double kSigma = 5e-5;
  Random random(7);
  const Rigid3 truth = motion_of(DependentElements{1, 0.03, -0.05, 0.04, -0.02, 0.06});
  const auto noisy = [&](const Vector3d& p) -> Vector2d {
    return p.hnormalized() + kSigma * Vector2d(random.normal(), random.normal());
  };
  std::vector<PairPoint> points;
  for (int i = 0; i < kPoints; ++i) {
    const Vector3d x(random.uniform(-0.2, 1.2), random.uniform(-1.2, 1.2), random.uniform(1.5, 1.9));
    points.push_back({noisy(x), noisy(truth * x), kSigma, kSigma});
  }
  return points;
}

// Blobs of all sizes, and noise.
GreyImage texture() {
  Random random(3);
  GreyImage image(kImageSide_px, kImageSide_px);
  std::vector<std::vector<double>> grids;
  for (const int step : {4, 16, 64}) {
    const int side = kImageSide_px / step + 2;
    grids.emplace_back(std::size_t(side) * std::size_t(side));
    for (double& grey : grids.back()) grey = random.uniform(-45, 45);
  }
  for (int y = 0; y < kImageSide_px; ++y)
    for (int x = 0; x < kImageSide_px; ++x) {
      double grey = 128 + 3 * random.normal();
      for (std::size_t k = 0; k < grids.size(); ++k) {
        const int step = 4 << (2 * k), side = kImageSide_px / step + 2;
        const double u = double(x) / step - x / step, v = double(y) / step - y / step;
        const double* at = grids[k].data() + std::ptrdiff_t(y / step) * side + x / step;
        grey += (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[side] + u * at[side + 1]);
      }
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
    }
  return image;
}

// What comes out must be right, or its time says nothing.
template <class Answer>
void must(const Answer& answer, const char* what) {
  if (answer) return;
  fmt::print(stderr, "{} gave no answer\n", what);
  std::exit(1);
}

Work resection(const Photograph& photo) {
  return [&photo] {
    const std::vector<Rigid3> starts{photo.start};
    must(space_resection(photo.camera, starts, photo.marks, photo.points), "resection");
  };
}

// Nothing known of the pose: it starts as the command does.
Work resection_with_start(const Photograph& photo) {
  std::vector<Vector2d> pixels;
  std::vector<Vector3d> points;
  for (const ResectionMark& mark : photo.marks) {
    pixels.push_back(mark.pixel);
    points.push_back(photo.points[mark.point].in_world);
  }
  return [&photo, pixels, points] {
    constexpr std::size_t kTriples = 40;
    const auto found = pose_starts(photo.camera, pixels, points, 1, kTriples);
    must(!found.empty(), "start of the resection");
    const std::vector<Rigid3> starts{found.front().cam_from_world};
    must(space_resection(photo.camera, starts, photo.marks, photo.points), "resection");
  };
}

Work relative(const std::vector<PairPoint>& points, PairStart start, PairRejection rejection) {
  RelativeOptions options;
  options.start = start;
  options.rejection = rejection;
  return [&points, options] { must(relative_orientation(points, options, 1), "relative orientation"); };
}

#ifdef COLLINEA_BENCH_OPENCV
cv::Mat view_of(const GreyImage& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data())};
}

// Levenberg-Marquardt from the same start.
Work solve_pnp(const Photograph& photo) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const ResectionPoint& point : photo.points)
    points.emplace_back(point.in_world.x(), point.in_world.y(), point.in_world.z());
  for (const ResectionMark& mark : photo.marks)  // their pixel centres are whole numbers
    pixels.emplace_back(mark.pixel.x() - 0.5, mark.pixel.y() - 0.5);
  const cv::Matx33d camera(4000, 0, 1999.5, 0, 4000, 1499.5, 0, 0, 1);
  const Vector3d turn = rotation_vector(photo.start.rotation), shift = photo.start.translation;
  return [=] {
    cv::Mat rotation = (cv::Mat_<double>(3, 1) << turn.x(), turn.y(), turn.z());
    cv::Mat translation = (cv::Mat_<double>(3, 1) << shift.x(), shift.y(), shift.z());
    must(cv::solvePnP(points, pixels, camera, cv::noArray(), rotation, translation, true, cv::SOLVEPNP_ITERATIVE),
         "solvePnP");
  };
}

// Five-point samples (least median, as our robust start) and the choice of the four solutions.
Work essential_matrix(const std::vector<PairPoint>& points) {
  std::vector<cv::Point2d> first, second;
  for (const PairPoint& point : points) {
    first.emplace_back(point.first.x(), point.first.y());
    second.emplace_back(point.second.x(), point.second.y());
  }
  return [=] {
    cv::Mat inliers, rotation, translation;
    const cv::Mat essential =
        cv::findEssentialMat(first, second, 1.0, cv::Point2d(0, 0), cv::LMEDS, 0.999, 1e-3, inliers);
    must(
        cv::recoverPose(essential, first, second, rotation, translation, 1.0, cv::Point2d(0, 0), inliers) > kPoints / 2,
        "recoverPose");
  };
}

Work umeyama(const std::vector<Vector3d>& model, const std::vector<Vector3d>& ground) {
  std::vector<cv::Point3d> from, to;
  for (const Vector3d& p : model) from.emplace_back(p.x(), p.y(), p.z());
  for (const Vector3d& p : ground) to.emplace_back(p.x(), p.y(), p.z());
  return [=] {
    double scale = 0;
    must(!cv::estimateAffine3D(from, to, &scale, true).empty(), "estimateAffine3D");
  };
}

Work corner_harris(const GreyImage& image) {
  return [&image] {
    cv::Mat map;
    cv::cornerHarris(view_of(image), map, 5, 3, 0.04);  // a box of 5 has the variance of a Gaussian of 1.41 px
  };
}

Work match_template(const GreyImage& image, const Eigen::Vector2i& middle) {
  return [&image, middle] {
    const auto around = [&](int size) {
      return view_of(image)(cv::Rect(middle.x() - size / 2, middle.y() - size / 2, size, size));
    };
    cv::Mat surface;
    cv::matchTemplate(around(kSearch_px + kTemplate_px - 1), around(kTemplate_px), surface, cv::TM_CCOEFF_NORMED);
  };
}
#else
template <class... Inputs>
Work solve_pnp(const Inputs&...) {
  return {};
}
template <class... Inputs>
Work essential_matrix(const Inputs&...) {
  return {};
}
template <class... Inputs>
Work umeyama(const Inputs&...) {
  return {};
}
template <class... Inputs>
Work corner_harris(const Inputs&...) {
  return {};
}
template <class... Inputs>
Work match_template(const Inputs&...) {
  return {};
}
#endif

// What all rows work on.
struct Inputs {
  std::vector<AbsoluteControl> pairs = control(true), uneven = control(false);
  std::vector<Vector3d> model, ground;
  Photograph exact{0}, measured{0.03};
  std::vector<PairPoint> points = pair_points();
  GreyImage image = texture();
  Eigen::Vector2i middle{kImageSide_px / 2, kImageSide_px / 2};

  Inputs() {
    for (const AbsoluteControl& pair : pairs) {
      model.push_back(pair.in_model);
      ground.push_back(pair.in_ground);
    }
  }
};

std::vector<Row> rows_of(const Inputs& in) {
  const double megapixels = 1e-6 * kImageSide_px * kImageSide_px;
  const auto map = [&in](InterestOperator method) {
    InterestOptions options;
    options.method = method;
    return [&in, options] { (void)interest_map(in.image, options); };
  };
  const auto surface = [&in](Similarity method) {
    return [&in, method] {
      (void)correlation_surface(in.image, in.middle, kTemplate_px / 2, in.image, in.middle, kSearch_px / 2, method);
    };
  };
  using enum PairStart;
  using enum PairRejection;
  return {
      {"absolute orientation", "", [&in] { must(absolute_orientation(in.pairs), "absolute"); }, {}, 0, 1},
      {"absolute, a covariance of each point",
       "",
       [&in] { must(absolute_orientation(in.uneven), "absolute"); },
       {},
       0,
       1},
      {"absolute, Umeyama alone", "estimateAffine3D (rotation)", [&in] { must(align(in.model, in.ground), "align"); },
       umeyama(in.model, in.ground)},
      {"resection", "solvePnP iterative", resection(in.exact), solve_pnp(in.exact), 0, 1},
      {"resection, control with errors", "solvePnP iterative", resection(in.measured), solve_pnp(in.measured), 0, 1},
      {"resection, start by P3P", "", resection_with_start(in.exact), {}, 0, 1},
      {"relative orientation, linear start", "", relative(in.points, kLinear, kNone), {}, 0, 1},
      {"relative, with data snooping", "", relative(in.points, kLinear, kSnooping), {}, 0, 1},
      {"relative, robust start, snooping", "findEssentialMat LMEDS, recoverPose",
       relative(in.points, kRobust, kSnooping), essential_matrix(in.points)},
      {"Harris", "cornerHarris (Sobel, box 5)", map(InterestOperator::kHarris), corner_harris(in.image), megapixels,
       40},
      {"NCC 21 x 21 in 201 x 201", "matchTemplate CCOEFF_NORMED", surface(Similarity::kNcc),
       match_template(in.image, in.middle), 0, 1},
      {"SSD 21 x 21 in 201 x 201", "", surface(Similarity::kSsd), {}, 0, 1},
  };
}

std::string cells(const Row& row, const Times& times) {
  const auto cell = [&](double ms) {
    return row.megapixels > 0 ? fmt::format("{:.0f} MP/s", 1e3 * row.megapixels / ms) : fmt::format("{:.3f} ms", ms);
  };
  return fmt::format("{} | {}", cell(times.least_ms), cell(times.median_ms));
}

void print(const Row& row, int repetitions) {
  const Times ours = times_of(row.ours, repetitions);
  const double figure = row.megapixels > 0 ? 1e3 * row.megapixels / ours.least_ms : ours.least_ms;
  const bool is_met = row.megapixels > 0 ? figure >= row.target : figure <= row.target;
  const std::string target = row.target == 0 ? ""
                                             : fmt::format("{} {}: {}", row.megapixels > 0 ? ">=" : "<=", row.target,
                                                           is_met ? "met" : "missed");
  fmt::print("| {} | {} | {} |", row.name, cells(row, ours), target);
  if (row.theirs) {
    const Times theirs = times_of(row.theirs, repetitions);
    fmt::print(" {} | {} | {:.1f} |\n", row.theirs_name, cells(row, theirs), theirs.least_ms / ours.least_ms);
  } else {
    fmt::print(" | | | |\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string part = argc > 1 ? argv[1] : "";
  const int repetitions = argc > 2 ? std::max(std::atoi(argv[2]), 1) : 200;
#ifdef COLLINEA_BENCH_OPENCV
  cv::setNumThreads(1);
#endif
  const Inputs inputs;
  fmt::print("{} points; images of {} x {} px; one thread, {} repetitions, processor time\n\n", kPoints, kImageSide_px,
             kImageSide_px, repetitions);
  fmt::print(
      "| step | least | median | wanted | OpenCV | least | median | theirs / ours "
      "|\n|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows_of(inputs))
    if (row.name.find(part) != std::string::npos)
      print(row, row.megapixels > 0 ? std::max(repetitions / 10, 1) : repetitions);
  return 0;
}
