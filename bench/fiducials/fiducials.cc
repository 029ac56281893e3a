// SPDX-License-Identifier: Apache-2.0
// How well fiducial marks are found: rendered scans of 60 mm at 15 um a pixel with eight marks of four kinds (1 mm
// wide), with grain, blur, rotation, shift, a film that is stretched and sheared, and marks that are turned on it.
//
// usage: collinea_bench_fiducials [SCANS [TURNED_MRAD]]     (200 scans; marks turned by 1 mrad, standard deviation)
//        collinea_bench_fiducials crop FILE KIND SIZE_PX LINE_PX     the best three marks in a photograph, and no more
//
// Prints of each kind how many were found, the error in a coordinate (RMS), the largest error of a position, how many
// are farther off than 0.1 px and how many their covariances let expect, chi-squared of errors over covariances for a
// degree of freedom, and the share within the 95 % ellipse; then the affine parameters of the film, likewise. Exit code
// 1: a mark that is missing or farther off than 0.1 px.
#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string_view>

#include "collinea/camera/film_fit.h"
#include "collinea/feature/fiducial_search.h"
#include "collinea/feature/scan_for_tests.h"
#include "collinea/raster/image_file.h"

using namespace collinea;

namespace {

constexpr std::array<MarkKind, 5> kKinds = {MarkKind::kCross, MarkKind::kDot, MarkKind::kRing, MarkKind::kCorner,
                                            MarkKind::kNotch};

constexpr double kBound_px = 0.1;
constexpr double kWithin95[] = {0, 3.841, 5.991, 0, 0, 0, 12.592};  // chi-squared of so many degrees of freedom

struct Tally {
  int wanted = 0, found = 0, beyond = 0, within = 0;
  double squares = 0, largest = 0, chi2 = 0, expected_beyond = 0;

  void add(const Eigen::Vector2d& off, const Eigen::Matrix2d& covariance) {
    ++found;
    squares += off.squaredNorm();
    largest = std::max(largest, off.norm());
    const double one = off.dot(covariance.inverse() * off);
    chi2 += one;
    within += one <= kWithin95[2];
    beyond += off.norm() > kBound_px;
    expected_beyond += std::exp(-kBound_px * kBound_px / covariance.trace());  // of a round ellipse of that size
  }
};

// Errors of what a film's transformation says over their standard deviations.
struct Recovered {
  int count = 0, within = 0, degrees = 1;
  double chi2 = 0;

  void add(double squared) {
    ++count;
    chi2 += squared;
    within += squared <= kWithin95[degrees];
  }
  void print(const char* what) const {
    const int n = std::max(1, count);
    fmt::print("{:<34}{:>12.3f}{:>12.1f}\n", what, chi2 / n / degrees, 100.0 * within / n);
  }
};

FilmCalibration camera(int scan) {
  FilmCalibration c;
  c.size_mm = {60, 60};
  c.mark_size_mm = 1;
  c.line_mm = 0.12;
  for (int i = 0; i < 8; ++i) {
    const double angle = i * std::numbers::pi / 4, r = i % 2 == 0 ? 28 : 26 * std::numbers::sqrt2;
    c.marks.push_back({.name = std::to_string(i + 1),
                       .film_mm = {r * std::cos(angle), r * std::sin(angle)},
                       .kind = kKinds[std::size_t(i % 4 + scan) % 5]});
  }
  return c;
}

// The best three marks of a kind in an image.
int look_at(char** argv) {
  const auto image = read_grey(argv[2]);
  const auto kind = from_word<MarkKind>(argv[3]);
  if (!image || !kind) return 2;
  const MarkModel drawn = drawn_mark(*kind, std::atof(argv[4]), std::atof(argv[5]), 0);
  const double reach = std::hypot(image->width, image->height) / 2;
  for (const FoundMark& found : search_mark(*image, drawn, {image->width / 2.0, image->height / 2.0}, reach, 3))
    fmt::print("{:.2f} {:.2f} +- {:.3f} {:.3f}  correlation {:.3f}\n", found.pixel.x(), found.pixel.y(),
               std::sqrt(found.covariance(0, 0)), std::sqrt(found.covariance(1, 1)), found.correlation);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 6 && std::string_view(argv[1]) == "crop") return look_at(argv);
  const int scans = argc > 1 ? std::atoi(argv[1]) : 200;
  const double turned_rad = argc > 2 ? 1e-3 * std::atof(argv[2]) : 1e-3;
  std::array<Tally, 5> tallies{};
  Recovered all{.degrees = 6}, difference, shear, rotation;
  for (int scan = 0; scan < scans; ++scan) {
    Random random(2026, std::uint64_t(scan));
    const FilmCalibration c = camera(scan);
    FilmTransformation truth;
    truth.model = FilmModel::kAffine;
    const double stretch = random.uniform(-5e-4, 5e-4), sheared = random.uniform(-3e-4, 3e-4), scale = 66.667;
    truth.parameters = (Eigen::VectorXd(6) << 2000 + random.uniform(-40, 40), 2000 + random.uniform(-40, 40),
                        random.uniform(-0.02, 0.02), scale * (1 + stretch), scale, sheared)
                           .finished();
    const ScanLook look{.blur_px = random.uniform(0.7, 1.8),
                        .grain = random.uniform(2, 5),
                        .grain_blur_px = 0.6,
                        .mark = random.uniform(140, 230),
                        .background = random.uniform(15, 60),
                        .mark_rotation_rad = turned_rad};
    const GreyImage image = rendered_scan(c, truth, 4000, 4000, look, 1.2, random);
    const auto found =
        find_fiducials(image, c, {.predicted = predicted_scan(c, 4000, 4000, 0.015, 0), .radius_mm = 2}, {});
    std::vector<FilmMark> marks;
    for (const CalibratedMark& mark : c.marks) {
      Tally& tally = tallies[std::size_t(*mark.kind)];
      ++tally.wanted;
      for (const FoundFiducial& one : found) {
        if (one.name != mark.name) continue;
        tally.add(one.mark.pixel - truth.pixel_of(mark.film_mm), one.mark.covariance);
        marks.push_back({mark.name, mark.film_mm, one.mark.pixel, one.mark.covariance});
      }
    }
    const FilmFitOptions known{.sigmas_are_known = true, .reject_misread = false};
    const auto fit = fit_film(marks, FilmModel::kAffine, known);
    const auto d = film_deformation(marks, known);
    if (!fit || !d) continue;
    const Eigen::VectorXd error = fit->transformation.parameters - truth.parameters;
    all.add(error.dot(fit->transformation.covariance.inverse() * error));
    difference.add(std::pow((d->difference_ppm.value - 1e6 * stretch) / d->difference_ppm.sigma, 2));
    shear.add(std::pow((d->shear_ppm.value - 1e6 * truth.parameters[5]) / d->shear_ppm.sigma, 2));
    rotation.add(std::pow((d->rotation_rad.value - truth.parameters[2]) / d->rotation_rad.sigma, 2));
  }
  bool is_good = all.count == scans;
  fmt::print("kind      wanted  found  RMS [px]  largest [px]  > 0.1 px  expected  chi2/degree  in 95 % [%]\n");
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    const Tally& t = tallies[k];
    const int n = std::max(1, t.found);
    fmt::print("{:<8}{:>8}{:>7}{:>10.4f}{:>14.4f}{:>10}{:>10.1f}{:>13.2f}{:>13.1f}\n", word_of(kKinds[k]), t.wanted,
               t.found, std::sqrt(t.squares / (2 * n)), t.largest, t.beyond, t.expected_beyond, t.chi2 / (2 * n),
               100.0 * t.within / n);
    is_good &= t.found == t.wanted && t.beyond == 0;
  }
  fmt::print("\nfilm, {} scans                      chi2/degree  in 95 % [%]\n", all.count);
  all.print("all six affine parameters");
  difference.print("difference of scales");
  shear.print("shear");
  rotation.print("rotation");
  return is_good ? 0 : 1;
}
