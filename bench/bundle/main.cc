// SPDX-License-Identifier: Apache-2.0
// Time of the bundle adjustment beside Ceres, on simulated aerial blocks with about 200 points an image.
//
// usage: collinea_bundle_bench [--images N,N,...] [--threads N] [--repeats N] [--ours]
// Built with -DCOLLINEA_BENCH=ON. A time is the median of the repeats, in seconds of the processor (all threads): of
// adjust() from block to block, and of ceres::Solve until it reaches the same cost within a part in a million (its
// problem is set up before the clock starts).
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "ceres_bundle.h"
#include "collinea/adjust/bundle.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"
#include "collinea/synthetic/survey.h"

namespace collinea::bench {
namespace {

struct Asked {
  std::vector<int> images = {100, 500, 2000};
  int threads = 1, repeats = 3;
  bool only_ours = false;
};

struct StartErrors {
  const char* name;
  double rotation_rad, move_m, point_m, focal;  // standard deviations; focal: the first over the true one, less one
};
constexpr StartErrors kStarts[] = {{"good", 0.001, 0.1, 0.2, 0.001}, {"poor", 0.02, 2, 3, 0.03}};

Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

// A share of the image points is wrong by up to 50 px.
Block block_of(int images, double wrong_share, const Run& run) {
  SurveyOptions survey;
  survey.images = images;
  survey.control_points = survey.check_points = 0;
  const auto truth = make_survey(survey, run);
  Block block = observations_only(*truth, {}, run).value();
  Random random(3);
  for (Observation& seen : block.observations)
    if (random.uniform() < wrong_share)
      seen.pixel += 50 * Eigen::Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
  return block;
}

Block start_of(Block block, const StartErrors& errors) {
  Random random(9);
  for (auto [id, pose] : oriented_images(block)) {
    const Eigen::Vector3d centre = centre_of(pose) + errors.move_m * normal3(random);
    const Eigen::Quaterniond rotation =
        (rotation_by(errors.rotation_rad * normal3(random)) * pose.rotation).normalized();
    pose = {rotation, -(rotation * centre)};
    set_pose(block, id, pose);
  }
  for (auto& [id, point] : block.points) point.position_in_world += errors.point_m * normal3(random);
  for (auto& [id, camera] : block.cameras) {
    const double share = errors.focal / 0.03;  // of what is not known of the lens
    camera.params[Camera::kF] *= 1 + errors.focal;
    for (int i = Camera::kK1; i <= Camera::kP2; ++i) camera.params[i] *= 1 - share;
    camera.params[Camera::kCx] += share * (0.5 * camera.width_px - camera.params[Camera::kCx]);
    camera.params[Camera::kCy] += share * (0.5 * camera.height_px - camera.params[Camera::kCy]);
    camera.prior.sigma_f_px = 0.05 * camera.focal_px();
  }
  return block;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void row(const Block& block, const std::string& start, const char* solver, double seconds, double ratio, int iterations,
         double cost, const std::string& note) {
  fmt::print("| {} | {} | {} | {} | {:.3f} | {} | {} | {:.2f} | {} |\n", count_oriented(block),
             block.observations.size() / count_oriented(block), start, solver, seconds,
             ratio > 0 ? fmt::format("{:.1f}", ratio) : "", iterations, cost, note);
  std::fflush(stdout);
}

void compare(const Block& exact, const StartErrors& errors, double wrong_share, const Asked& asked, const Run& run) {
  const Block block = start_of(exact, errors);
  const std::string start = fmt::format("{}, {:g} % wrong", errors.name, 100 * wrong_share);
  std::vector<double> times;
  Result<Adjusted> ours;
  for (int i = 0; i < asked.repeats; ++i) {
    const double begin = cpu_seconds();
    ours = adjust(block, {}, {.calibration = Calibration::kBrown}, run);
    times.push_back(cpu_seconds() - begin);
  }
  if (!ours) {
    std::printf("adjust: %s\n", ours.error().message.c_str());
    return;
  }
  const double seconds = median(times);
  row(block, start, "collinea", seconds, 0, ours->iterations, ours->final_cost,
      fmt::format("sigma0 {:.3f}", ours->sigma0));
  if (asked.only_ours) return;
  const struct {
    CeresSolver solver;
    const char* name;
  } solvers[] = {{CeresSolver::kDense, "Ceres DENSE_SCHUR"},
                 {CeresSolver::kSparse, "Ceres SPARSE_SCHUR"},
                 {CeresSolver::kIterative, "Ceres ITERATIVE_SCHUR"}};
  for (const auto& [solver, name] : solvers) {
    if (solver == CeresSolver::kDense && count_oriented(block) > 500) continue;
    std::vector<double> to_cost;
    CeresOutcome outcome;
    for (int i = 0; i < asked.repeats; ++i) {
      outcome = ceres_bundle(block, block, solver, asked.threads, ours->final_cost * (1 + 1e-6));
      to_cost.push_back(outcome.seconds_to_cost);
    }
    const double theirs = median(to_cost);
    row(block, start, name, theirs, theirs / seconds, outcome.iterations, outcome.final_cost,
        fmt::format("{}all {:.2f} s: derivatives {:.2f}, linear {:.2f}", outcome.reached ? "" : "never at that cost; ",
                    outcome.seconds, outcome.jacobian_seconds, outcome.linear_seconds));
  }
}

Asked asked_by(int argc, char** argv) {
  Asked asked;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--ours") asked.only_ours = true;
    if (i + 1 == argc) break;
    if (word == "--threads") asked.threads = std::max(1, std::atoi(argv[i + 1]));
    if (word == "--repeats") asked.repeats = std::max(1, std::atoi(argv[i + 1]));
    if (word == "--images") {
      asked.images.clear();
      std::istringstream list(argv[i + 1]);
      for (std::string number; std::getline(list, number, ',');) asked.images.push_back(std::atoi(number.c_str()));
    }
  }
  return asked;
}

}  // namespace
}  // namespace collinea::bench

int main(int argc, char** argv) {
  using namespace collinea::bench;
  const Asked asked = asked_by(argc, argv);
  const std::string threads = std::to_string(asked.threads);
  if (const char* set = std::getenv("OPENBLAS_NUM_THREADS"); !set || threads != set) {
    setenv("OPENBLAS_NUM_THREADS", threads.c_str(), 1);  // the library reads it when it is loaded
    execv("/proc/self/exe", argv);
  }
  collinea::Run run;
  run.threads = asked.threads;
  fmt::print("| images | points an image | start | solver | s | Ceres over ours | iterations | cost | |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  for (const int images : asked.images) {
    for (const double wrong_share : {0.01, 0.0}) {
      const collinea::Block block = block_of(images, wrong_share, run);
      for (const StartErrors& errors : kStarts) compare(block, errors, wrong_share, asked, run);
    }
  }
}
