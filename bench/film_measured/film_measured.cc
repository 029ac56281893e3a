// SPDX-License-Identifier: Apache-2.0
// Do check points of a block of film lie within what its adjustment predicts? Blocks of 3 x 6 scans as `simulate
// --film` has them, with its deformation of film, by measurements alone: marks to 0.02 px, tie points to 0.39 px,
// control and twelve check points to 0.25 px of 60 um. Nothing is rendered or matched, and there is no refraction.
//
// usage: collinea_bench_film_measured FIRST_SEED LAST_SEED [CONTROL [TIE_POINTS [LOCAL_UM]]]     (12, 4000, 4)
//
// Prints of each block, with the deformation left out and with it among the unknowns, the errors of check points (RMS)
// in east, north and height, what was predicted, squares of errors over sigmas, how many lie within the 95 %
// ellipsoid, and how much of control was rejected; then chi-squared over its degrees and the sums.
#include <fmt/core.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "collinea/film/scan_deformation.h"
#include "collinea/math/median.h"
#include "collinea/quality/film_estimate.h"
#include "collinea/quality/snooping.h"
#include "collinea/synthetic/film.h"

using namespace collinea;

namespace {

constexpr double kTie_px = 0.39, kMark_px = 0.02, kPixel_um = 60, kWithin95 = 7.815;
constexpr double kRelief_m = 3, kMissed = 0.3;  // of tie points: heights about their mean, rays that were not matched
const Run kRun;

struct Tally {
  int within = 0, checks = 0, rejected = 0;
  double chi2 = 0;
  Eigen::Vector3d squares{0, 0, 0}, variances{0, 0, 0}, weighted{0, 0, 0};

  void add(const Tally& other) {
    within += other.within, checks += other.checks, rejected += other.rejected;
    chi2 += other.chi2;
  }
};

Eigen::Vector2d normal2(Random& random) {
  const double x = random.normal(), y = random.normal();
  return {x, y};
}

/// The scans of a block with their interior orientation.
struct Scans {
  IdealImage ideal;
  std::map<ImageId, ScanOrientation> oriented;
  std::vector<FilmPrior> priors;  ///< in the order of the scans

  [[nodiscard]] Eigen::Vector2d in_ideal(ImageId id, const Eigen::Vector2d& scan_px) const {
    return ideal.pixel_of(*oriented.at(id).scan_from_film().film_of(scan_px));
  }
};

Scans scans_of(const FilmTruth& film, Random& random) {
  Scans scans;
  std::vector<double> sizes_mm;
  std::vector<const ScanOrientation*> in_order;
  for (const auto& [id, scan] : film.scans) {
    ScanMarks marks;
    for (const CalibratedMark& mark : film.calibration.marks)
      marks.marks.push_back({mark.name, scan.pixel_of(mark.film_mm) + kMark_px * normal2(random), kMark_px});
    const ScanOrientation& its = scans.oriented.emplace(id, *oriented_scan(film.calibration, marks)).first->second;
    sizes_mm.push_back(its.pixel_mm());
    in_order.push_back(&its);
  }
  scans.ideal = ideal_image(film.calibration, median(sizes_mm));
  scans.priors = scan_deformation(in_order, scans.ideal, {});
  return scans;
}

void add_tie_points(const FilmTruth& film, const Scans& scans, int points, Random& random, Block& block) {
  const Block& truth = film.truth.block;
  const Camera& camera = truth.cameras.begin()->second;
  double ground_m = 0;
  for (const auto& [id, mark] : film.truth.marks_in_world)
    ground_m += mark.z() / double(film.truth.marks_in_world.size());
  std::vector<ImageId> images;
  for (const auto& [id, image] : truth.images) images.push_back(id);
  for (std::uint32_t i = 0; i < std::uint32_t(points); ++i) {
    const Rigid3 from = pose_of(truth, images[i % images.size()]);
    const double column = random.uniform(0, camera.width_px), row = random.uniform(0, camera.height_px);
    const Eigen::Vector3d ray = from.rotation.conjugate() * ray_in_cam(camera, {column, row}), centre = centre_of(from);
    const double height_m = ground_m + kRelief_m * random.normal();
    const Eigen::Vector3d point = centre + ray * ((height_m - centre.z()) / ray.z());
    std::vector<Observation> rays;
    for (const ImageId id : images) {
      const Eigen::Vector2d noise = kTie_px * normal2(random);
      const auto pixel = project(camera, pose_of(truth, id) * point);
      if (!pixel || !inside(camera, *pixel) || random.uniform() < kMissed) continue;
      rays.push_back({id, PointId{i}, 0, scans.in_ideal(id, scan_pixel_of(film, id, *pixel)) + noise, kTie_px});
    }
    if (rays.size() < 2) continue;
    block.points[PointId{i}].position_in_world = point;
    block.observations.insert(block.observations.end(), rays.begin(), rays.end());
  }
}

// Every scan with a camera of its own.
Block measured_block(const FilmTruth& film, const Scans& scans, int points, Random& random) {
  const Block& truth = film.truth.block;
  Block block;
  block.control = truth.control;
  std::size_t number = 0;
  for (const auto& [id, image] : truth.images) {
    block.images[id].camera = CameraId{id.value};
    Camera& camera = block.cameras[CameraId{id.value}] = scans.ideal.camera;
    if (!scans.priors.empty()) camera.prior.film = scans.priors[number++];
    set_pose(block, id, pose_of(truth, id));
  }
  for (ControlObservation seen : truth.control_observations) {
    seen.pixel = scans.in_ideal(seen.image, scan_pixel_of(film, seen.image, seen.pixel));
    block.control_observations.push_back(seen);
  }
  add_tie_points(film, scans, points, random, block);
  return block;
}

ExamineOptions options_of_steps() {
  ExamineOptions options{.adjust = {.calibration = Calibration::kNone}, .reliability = true};
  options.adjust.loss = options.adjust.position_loss = Loss::kNone;
  options.adjust.relative_cost_change = 1e-12;
  options.adjust.step_sigmas = 1e-3;
  options.systematics.test = false;
  return options;
}

Tally adjusted(const Block& block) {
  const auto snooped = snoop(block, {.use_positions = false}, options_of_steps(), 1000, kRun, SnoopedKinds::kGiven);
  if (!snooped) {
    fmt::print("{}\n", snooped.error().message);
    std::exit(1);
  }
  Tally tally{.rejected = int(snooped->rejected.size())};
  const double variance = std::pow(sigma_scale(snooped->adjusted), 2);
  for (const ControlDifference& check : snooped->adjusted.control) {
    if (block.control.at(check.point).role != ControlRole::kCheck || !check.covariance_m2) continue;
    const Eigen::Matrix3d covariance = variance * *check.covariance_m2;
    const double square = check.difference_m.dot(covariance.inverse() * check.difference_m);
    ++tally.checks;
    tally.within += square < kWithin95;
    tally.chi2 += square / 3;
    tally.squares += check.difference_m.cwiseAbs2();
    tally.variances += covariance.diagonal();
    tally.weighted += check.difference_m.cwiseAbs2().cwiseQuotient(covariance.diagonal());
  }
  return tally;
}

void print(int seed, const char* what, const Tally& tally, const std::string& process = "") {
  const auto triple = [&](const Eigen::Vector3d& v, int digits) {
    return fmt::format("{:.{}f} {:.{}f} {:.{}f}", v[0], digits, v[1], digits, v[2], digits);
  };
  const double n = std::max(1, tally.checks);
  fmt::print("| {} | {} | {} | {} | {} | {} of {} | {} | {}\n", seed, what, triple((tally.squares / n).cwiseSqrt(), 3),
             triple((tally.variances / n).cwiseSqrt(), 3), triple(tally.weighted / n, 2), tally.within, tally.checks,
             tally.rejected, process);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
  Tally without, with;
  for (int seed = std::atoi(argv[1]); seed <= std::atoi(argv[2]); ++seed) {
    SurveyOptions survey{.control_points = int(number(3, 12)), .seed = seed};
    FilmOptions options{.film = true, .scan_um = kPixel_um};
    options.wear.film_local_um = number(5, 4);
    auto film = make_film_survey(survey, options, kRun);
    if (!film) return 1;
    for (auto& [id, image] : film->truth.block.images) image.bend = {};
    Random random(std::uint64_t(seed), 99);
    const Scans scans = scans_of(*film, random);
    Block block = measured_block(*film, scans, int(number(4, 4000)), random);
    const Tally plain = adjusted(block);
    print(seed, "left out", plain);
    without.add(plain);
    add_film(block);
    const auto found = estimate_film(block, {.use_positions = false}, options_of_steps(), kRun);
    if (!found) return 1;
    const double um = 1e3 * scans.ideal.pixel_mm;
    const Tally deformed = adjusted(block);
    print(seed, "unknown", deformed,
          fmt::format("{:.1f} um, {:.0f} mm after {} steps", um * found->process.sigma_px,
                      1e-3 * um * found->process.correlation_px, found->iterations));
    with.add(deformed);
  }
  for (const auto& [what, tally] : {std::pair("left out", without), std::pair("unknown", with)})
    fmt::print("{}: {} of {} within 95 %, chi-squared over its degrees {:.2f}, {} rejected\n", what, tally.within,
               tally.checks, tally.chi2 / std::max(1, tally.checks), tally.rejected);
  return 0;
}
