// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/relative_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/report/findings_text.h"
#include "collinea/report/internal/relative_values.h"
#include "collinea/report/single_step.h"

namespace collinea {

using namespace relative;

namespace {

std::string list_text(const std::vector<Element>& elements, const Matrix5& covariance) {
  std::string text;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Element& e = elements[i];
    text += fmt::format("  {:<7}{:>12.6f} {:<4} sigma {:.6f}", e.name, e.value, e.unit == "1" ? "" : e.unit, e.sigma);
    for (std::size_t k = 0; k < i && e.sigma > 0; ++k) {  // what is given without a sigma is exact
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(k);
      text += fmt::format("{}{:6.2f}", k == 0 ? "   correlations " : "", correlation_of(covariance, row, column));
    }
    text += "\n";
  }
  return text;
}

std::string head(const RelativeReport& report) {
  const RelativeOrientation& o = report.orientation;
  std::string text = report.is_given
                         ? fmt::format("the orientation is as given: {} points compared with it, {} rejected\n", o.used,
                                       o.rejected.size())
                         : fmt::format("relative orientation of {} points, {} rejected; redundancy {:.6g}\n", o.used,
                                       o.rejected.size(), o.redundancy);
  if (o.redundancy == 0) return text + "five points: nothing checks them\n";
  const std::string_view unit = report.frame.unit();
  if (report.options.sigma_known) {
    text += fmt::format("sigma0 {:.3f} of the standard deviations as given; they are what is stated below\n", o.sigma0);
  } else if (report.sigma > 0) {
    text += fmt::format("standard deviation of a coordinate, from the residuals: {:.4f} {}\n", o.sigma0 * report.sigma,
                        unit);
  } else {
    text += fmt::format("sigma0 {:.3f}, by which standard deviations are multiplied\n", o.sigma0);
  }
  return text;
}

// How the exhaustive search went, where it was the start.
std::string start_text(const RelativeReport& report) {
  const auto& search = report.orientation.search;
  if (!search) return "";
  return fmt::format(
      "exhaustive search: {} of {} starts converge; {} different orientations fit as well as the best, "
      "misclosure {:.2g} (unit rays, unit base)\n",
      search->converged, search->starts, search->distinct.size(), search->rms);
}

// The four motions with the same coplanarity, and which of them was chosen.
std::string solutions_text(const RelativeReport& report) {
  std::string text = fmt::format("the four solutions, points of {} in front of both images; the first one is chosen:\n",
                                 report.orientation.used);
  text += fmt::format("  {:>8}{:>5}{:>11}{:>11}{:>11}{:>11}{:>11} {}\n", "in front", "bx", "by", "bz", "omega deg",
                      "phi deg", "kappa deg", " phi1, kappa1, omega2, phi2, kappa2 deg");
  for (const RelativeSolution& solution : report.solutions) {
    text += fmt::format("  {:>8}", solution.in_front);
    if (const auto d = dependent_elements(solution.second_from_first))
      text += fmt::format("{:>5g}{:>11.5f}{:>11.5f}{:>11.5f}{:>11.5f}{:>11.5f}  ", d->bx, d->by, d->bz,
                          d->omega * kDegrees, d->phi * kDegrees, d->kappa * kDegrees);
    else
      text += fmt::format("{:>5}{:>11}{:>11}{:>11}{:>11}{:>11}  ", "-", "-", "-", "-", "-", "-");
    const SymmetricElements s = symmetric_elements(solution.second_from_first);
    for (const double angle : {s.phi1, s.kappa1, s.omega2, s.phi2, s.kappa2})
      text += fmt::format(" {:.5f}", angle * kDegrees);
    text += "\n";
  }
  return text;
}

std::string elements_text(const RelativeReport& report) {
  std::string text;
  if (const auto d = dependent(report))
    text += fmt::format("dependent pair, bx = {:g}:\n", d->elements.bx) + list_text(dependent_list(*d), d->covariance);
  else
    text += "dependent pair: the base has no component along x, by and bz are without bound\n";
  const SymmetricWithCovariance s = symmetric(report);
  text += "symmetric pair (independent), omega1 = 0:\n" + list_text(symmetric_list(s), s.covariance);
  if (report.is_given)
    text += fmt::format("it has {} of {} points in front of both images\n", report.orientation.in_front,
                        report.orientation.used);
  else
    text += start_text(report) + solutions_text(report);
  return text;
}

double parallax_of(const RelativeReport& report, std::size_t i) {
  return report.orientation.residuals[i].y_parallax * report.frame.camera.focal_px();
}

std::string residual_head(const RelativeReport& report, const char* of) {
  return fmt::format("{} [{}]:\n  {:<12}{:>10}{:>10}{:>10}{:>10}{:>12}{:>8}{:>8}\n", of, report.frame.unit(), "point",
                     "x left", "y left", "x right", "y right", "y-parallax", "r", "test");
}

double test_of(const RelativeReport& report, std::size_t i) {
  const double unit = unit_weight(report);
  return unit > 0 ? report.orientation.residuals[i].standardised / unit : 0;
}

std::string residual_row(const RelativeReport& report, std::size_t i) {
  const PairResidual& residual = report.orientation.residuals[i];
  const Eigen::Vector4d v = residual_of(report, i);
  return fmt::format("  {:<12}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}{:>12.4f}{:>8.2f}{:>8.2f}{}\n", report.names[i], v(0),
                     v(1), v(2), v(3), parallax_of(report, i), residual.redundancy, test_of(report, i),
                     residual.used ? "" : "  rejected");
}

std::string parallax_text(const RelativeReport& report) {
  double squares = 0;
  for (std::size_t i = 0; i < report.points.size(); ++i)
    if (report.orientation.residuals[i].used) squares += parallax_of(report, i) * parallax_of(report, i);
  return fmt::format("residual y-parallax, root mean square: {:.4f} {}\n",
                     std::sqrt(squares / std::max(1, report.orientation.used)), report.frame.unit());
}

std::string rejection_text(const RelativeReport& report) {
  if (report.options.rejection == PairRejection::kSnooping)
    return fmt::format("test: residual over its standard deviation; beyond {:.2f} a point is rejected\n",
                       report.orientation.limit);
  if (report.options.rejection == PairRejection::kResidual)
    return fmt::format("rejected: residuals beyond {:.2f} sigma0\n", report.options.residual_limit);
  return "";
}

// The largest tests first.
std::string rejected_text(const RelativeReport& report, std::size_t most) {
  std::vector<std::size_t> rejected(report.orientation.rejected.begin(), report.orientation.rejected.end());
  if (rejected.empty() || most == 0) return "";
  std::stable_sort(rejected.begin(), rejected.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(test_of(report, a)) > std::abs(test_of(report, b));
  });
  std::string text = residual_head(
      report, "residuals of rejected points, with the tests of the end (each was the largest in its turn)");
  for (std::size_t k = 0; k < std::min(most, rejected.size()); ++k) text += residual_row(report, rejected[k]);
  if (rejected.size() > most) text += fmt::format("  and {} more\n", rejected.size() - most);
  return text;
}

std::string residuals_text(const RelativeReport& report) {
  std::string text = residual_head(report, "residuals");
  for (std::size_t i = 0; i < report.points.size(); ++i) text += residual_row(report, i);
  text += parallax_text(report) + rejection_text(report);
  for (const int i : report.orientation.rejected)
    text += fmt::format("rejected: {}\n", report.names[static_cast<std::size_t>(i)]);
  return text;
}

// The combination of elements that is known worst: those with a share of a tenth at least.
std::string null_text(const PairShape& shape) {
  static constexpr std::array<const char*, 5> kNames = {"by", "bz", "omega", "phi", "kappa"};
  static constexpr std::array<const char*, 5> kOthers = {"turn about x", "turn about y", "turn about z",
                                                         "first direction of the base", "second direction of the base"};
  std::string text;
  for (int i = 0; i < 5; ++i)
    if (const double share = shape.null_vector(i); std::abs(share) >= 0.1) {
      const auto k = static_cast<std::size_t>(i);
      text += fmt::format("{}{:.2f} {}",
                          text.empty() ? ""
                          : share < 0  ? " - "
                                       : " + ",
                          text.empty() ? share : std::abs(share), shape.of_elements ? kNames[k] : kOthers[k]);
    }
  return text;
}

std::string sentence_of(PairWeakness weakness, const RelativeReport& report) {
  const PairShape& shape = *report.shape;
  const auto metres = [&](double bases) {
    return fmt::format("{:.4g}{}", bases * report.base, report.base_is_given ? " m" : "");
  };
  switch (weakness) {
    case PairWeakness::kCylinder:
      return fmt::format(
          "critical: points and base lie on a cylinder of radius {}, rough by {} only. The orientation is not "
          "determined; measure points off it, or use images with another base\n",
          metres(shape.cylinder->radius), metres(shape.cylinder->roughness));
    case PairWeakness::kNearCylinder:
      return fmt::format(
          "weak: points and base lie near a cylinder of radius {}, rough by {} ({:.1f} % of the distance). Measure "
          "points further from the base line, or at other heights\n",
          metres(shape.cylinder->radius), metres(shape.cylinder->roughness),
          100 * shape.cylinder->roughness / shape.distance);
    case PairWeakness::kPlane:
      return fmt::format(
          "note: the points lie in a plane (within {}): a second orientation fits them as well, or nearly. Check "
          "this one by what is known of the attitudes, or measure points off the plane\n",
          metres(shape.plane_roughness));
    case PairWeakness::kBasePlane:
      return "critical: the points lie in one plane with the base: measure points on both sides of it\n";
    case PairWeakness::kNarrow:
      return fmt::format(
          "weak: the points lie near one plane with the base, in a narrow band along it ({:.1f} degrees, one standard "
          "deviation; rough by {}): measure points further from it\n",
          shape.breadth * kDegrees, metres(shape.base_plane_roughness));
    case PairWeakness::kNearPlane:
      return fmt::format("note: the points lie near a plane (within {}, {:.1f} % of the distance)\n",
                         metres(shape.plane_roughness), 100 * shape.plane_roughness / shape.distance);
    case PairWeakness::kShortBase:
      return fmt::format("weak: rays meet at {:.2f} degrees only: the base is short\n",
                         shape.median_angle_rad * kDegrees);
  }
  return "";
}

// The other orientation that a plane allows, and whether the points tell it from this one.
std::string second_text(const RelativeReport& report) {
  if (!report.second) return "";
  const RelativeOrientation& second = *report.second;
  std::string text =
      fmt::format("the second orientation of that plane, {} of {} points in front:\n", second.in_front, second.used);
  if (const auto d = dependent_elements(second.second_from_first))
    text += fmt::format("  bx {:g}, by {:.5f}, bz {:.5f}, omega {:.5f}, phi {:.5f}, kappa {:.5f} deg\n", d->bx, d->by,
                        d->bz, d->omega * kDegrees, d->phi * kDegrees, d->kappa * kDegrees);
  const SymmetricElements s = symmetric_elements(second.second_from_first);
  text +=
      fmt::format("  phi1 {:.5f}, kappa1 {:.5f}, omega2 {:.5f}, phi2 {:.5f}, kappa2 {:.5f} deg\n", s.phi1 * kDegrees,
                  s.kappa1 * kDegrees, s.omega2 * kDegrees, s.phi2 * kDegrees, s.kappa2 * kDegrees);
  return text + fmt::format("  its sigma0 is {:.3f}, that of the first one {:.3f}\n", second.sigma0,
                            report.orientation.sigma0);
}

// The simplified orientation beside the rigorous one.
std::string linear_text(const RelativeReport& report) {
  if (!report.linear) return "";
  const LinearOrientation& linear = *report.linear;
  double squares = 0;
  for (const double parallax : linear.parallaxes) squares += parallax * parallax;
  const double rms = std::sqrt(squares / double(linear.parallaxes.size())) * report.frame.camera.focal_px();
  return fmt::format(
      "simplified orientation, linear in the y-parallaxes (bx = 1; products of elements neglected), and "
      "the rigorous one:\n{}its residual y-parallax, root mean square: {:.4f} {}; sigma0 {:.3f}\n",
      indented_rows(relative_linear_table(report)), rms, report.frame.unit(), linear.sigma0);
}

std::string shape_text(const RelativeReport& report) {
  if (report.is_given) return "";  // the points determine nothing
  if (!report.shape) return "fewer than five points in front of both images: their geometry is not judged\n";
  const PairShape& shape = *report.shape;
  const std::string unit = report.base_is_given ? " m" : " (base = " + fmt::format("{:g}", report.base) + ")";
  std::string text = fmt::format(
      "geometry: mean distance {:.4g}{}, extent along the base {:.4g}, direction about the base +-{:.1f} deg, rays "
      "meet at {:.2f} deg\n",
      shape.distance * report.base, unit, shape.width * report.base, shape.breadth * kDegrees,
      shape.median_angle_rad * kDegrees);
  text += fmt::format(
      "conditioning: lambda_min / lambda_max = {:.2g} as it is, {:.2g} scaled; correlations enlarge the worst sigma "
      "{:.1f} times\n",
      shape.epsilon_raw, shape.epsilon, shape.inflation);
  text += fmt::format("known worst, each in units of its sigma with the others known: {}\n", null_text(shape));
  text += fmt::format("roughness of the plane that fits best: {:.4g}, of the plane through the base: {:.4g}\n",
                      shape.plane_roughness * report.base, shape.base_plane_roughness * report.base);
  if (shape.cylinder)
    text += fmt::format(
        "cylinder through the base that fits best: radius {:.4g}, roughness {:.4g} ({:.1f} % of the "
        "distance)\n",
        shape.cylinder->radius * report.base, shape.cylinder->roughness * report.base,
        100 * shape.cylinder->roughness / shape.distance);
  for (const PairWeakness weakness : shape.weaknesses) text += sentence_of(weakness, report);
  return text + second_text(report);
}

std::string distances_text(const RelativeReport& report) {
  if (!report.scaled) return "";
  const ScaledPair& pair = *report.scaled;
  std::string text = fmt::format("base by {} distances: {:.4f} m, sigma {:.4f} m", pair.residuals.size(), pair.base,
                                 std::sqrt(pair.covariance(5, 5)));
  text += pair.redundancy > 0 ? fmt::format("; sigma0 of the distances {:.2f}\n", pair.sigma0)
                              : std::string("; nothing checks it\n");
  for (std::size_t k = 0; k < report.distances.size(); ++k) {
    const RelativeReport::Distance& d = report.distances[k];
    text += fmt::format("  {:<10} {:<10}{:>12.4f} m   residual {:>9.4f} m   test {:>6.2f}\n", d.from, d.to, d.length_m,
                        pair.residuals[k], pair.standardised[k]);
  }
  return text;
}

// What is given in its three forms, and the points for it.
std::string given_text(const RelativeReport& report) {
  std::string text = fmt::format("the orientation is as given, {}: nothing is solved\n", word_of(*report.given_form));
  if (const auto d = dependent(report))
    text += fmt::format("dependent pair, bx = {:g}:\n", d->elements.bx) + list_text(dependent_list(*d), d->covariance);
  else
    text += "dependent pair: the base has no component along x, by and bz are without bound\n";
  const SymmetricWithCovariance s = symmetric(report);
  text += "symmetric pair (independent), omega1 = 0:\n" + list_text(symmetric_list(s), s.covariance);
  text += fmt::format("exterior orientation of the right image in the axes of the left one, base {:.6g}{}:\n",
                      report.base, report.base_is_given ? " m" : "");
  std::vector<Estimate> exterior;
  static constexpr std::array<const char*, 6> kNames = {"X", "Y", "Z", "omega", "phi", "kappa"};
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    exterior.push_back({kNames[k], k < 3 ? (report.base_is_given ? "m" : "") : "deg", report.right_pose(i),
                        std::sqrt(std::max(0.0, report.right_covariance(i, i)))});
  }
  text += estimates_text(exterior);
  if (!report.coplanarity) return text;
  double squares = 0;
  for (const PointCoplanarity& one : report.coplanarity->points) squares += one.gap * one.gap;
  text += fmt::format("coplanarity of {}, {} of them in front of both images:\n",
                      counted_text(report.names.size(), "point"), report.orientation.in_front) +
          indented_rows(relative_coplanarity_table(report));
  text += fmt::format("gap, root mean square: {:.4f} {}\n",
                      std::sqrt(squares / double(report.names.size())) * report.frame.camera.focal_px(),
                      report.frame.unit());
  return text +
         fmt::format("sigma0 of all conditions by the sigmas of points and elements: {:.3f}\n",
                     report.coplanarity->sigma0) +
         findings_text(report.findings);
}

}  // namespace

std::string relative_text(const RelativeReport& report) {
  if (report.given_form) return given_text(report);
  return head(report) + elements_text(report) + linear_text(report) + residuals_text(report) + distances_text(report) +
         shape_text(report) + findings_text(report.findings);
}

std::string relative_summary_text(const RelativeReport& report, std::size_t most_rejected) {
  return head(report) + elements_text(report) + linear_text(report) + parallax_text(report) + rejection_text(report) +
         rejected_text(report, most_rejected) + distances_text(report) + shape_text(report);
}

std::string pair_shape_text(const RelativeReport& report) { return shape_text(report); }

}  // namespace collinea
