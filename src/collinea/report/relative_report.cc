// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/relative_report.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/geometry/rotation.h"
#include "collinea/math/fisher.h"
#include "collinea/report/single_step.h"

namespace collinea {
namespace {

constexpr double kFront = 0.9, kManyRejected = 0.2;  // shares of the points
constexpr double kDegrees = 180 / std::numbers::pi;

// One element of the orientation, in the unit for people.
struct Element {
  std::string name;
  double value, sigma;
  std::string unit;
};

std::vector<Element> elements_of(const Vector5& values, const Matrix5& covariance,
                                 const std::array<const char*, 5>& names, int lengths) {
  std::vector<Element> out;
  for (int i = 0; i < 5; ++i) {
    const double factor = i < lengths ? 1 : kDegrees;
    out.push_back({names[static_cast<std::size_t>(i)], values(i) * factor,
                   std::sqrt(std::max(0.0, covariance(i, i))) * factor, i < lengths ? "1" : "deg"});
  }
  return out;
}

Matrix5 covariance_by(const Matrix5& by, const RelativeOrientation& orientation) {
  return by * orientation.stated_covariance() * by.transpose();
}

std::optional<DependentWithCovariance> dependent(const RelativeReport& report) {
  const Rigid3& motion = report.orientation.second_from_first;
  const auto elements = dependent_elements(motion);
  if (!elements) return std::nullopt;
  return DependentWithCovariance{*elements, covariance_by(dependent_by_change(motion), report.orientation)};
}

SymmetricWithCovariance symmetric(const RelativeReport& report) {
  const Rigid3& motion = report.orientation.second_from_first;
  return {symmetric_elements(motion), covariance_by(symmetric_by_change(motion), report.orientation)};
}

std::vector<Element> dependent_list(const DependentWithCovariance& d) {
  return elements_of(d.elements.values(), d.covariance, {"by", "bz", "omega", "phi", "kappa"}, 2);
}

std::vector<Element> symmetric_list(const SymmetricWithCovariance& s) {
  return elements_of(s.elements.values(), s.covariance, {"phi1", "kappa1", "omega2", "phi2", "kappa2"}, 0);
}

// 0 where one of the two is exact.
double correlation_of(const Matrix5& covariance, Eigen::Index row, Eigen::Index column) {
  const double product = covariance(row, row) * covariance(column, column);
  return product > 0 ? covariance(row, column) / std::sqrt(product) : 0;
}

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

// Residuals in the unit and the axes of the table.
Eigen::Vector4d residual_of(const RelativeReport& report, std::size_t i) {
  const PairResidual& residual = report.orientation.residuals[i];
  const double f = report.frame.camera.focal_px();
  Eigen::Vector4d v;
  v << residual.first * f, residual.second * report.second_principal_distance.value_or(f);
  if (report.frame.y_up) {
    v(1) = -v(1);
    v(3) = -v(3);
  }
  return v;
}

double unit_weight(const RelativeReport& report) { return std::sqrt(report.orientation.variance_factor); }

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
    const double chance = fisher_tail(o.sigma0 * o.sigma0, o.redundancy, INFINITY);
    text += fmt::format("sigma0 {:.3f} of the standard deviations as given; they are what is stated below\n", o.sigma0);
    if (chance < VarianceTest::kLevel)
      text += fmt::format(
          "the residuals are larger than the standard deviations allow (chance {:.1g}): they are too small, by about "
          "{:.1f} times, or errors are left\n",
          chance, o.sigma0);
  } else if (report.sigma > 0) {
    text += fmt::format("standard deviation of a coordinate, from the residuals: {:.4f} {}\n", o.sigma0 * report.sigma,
                        unit);
  } else {
    text += fmt::format("sigma0 {:.3f}, by which standard deviations are multiplied\n", o.sigma0);
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
  text += fmt::format("{} has {} of {} points in front of both images\n",
                      report.is_given ? "it" : "of the four solutions this one", report.orientation.in_front,
                      report.orientation.used);
  const RelativeOrientation& o = report.orientation;
  if (o.in_front < kFront * o.used)
    text += "wrong: rays of many points meet behind an image. The points are not those of two views of one object\n";
  if (static_cast<double>(o.rejected.size()) > kManyRejected * static_cast<double>(report.points.size()))
    text += fmt::format("weak: {} of {} points are rejected; look at the measurements\n", o.rejected.size(),
                        report.points.size());
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
  std::string text = residual_head(report, "residuals of rejected points");
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
          "weak: the points lie in a narrow band along the base ({:.1f} degrees, one standard deviation): measure "
          "points further from it\n",
          shape.breadth * kDegrees);
    case PairWeakness::kShortBase:
      return fmt::format("weak: rays meet at {:.2f} degrees only: the base is short\n",
                         shape.median_angle_rad * kDegrees);
  }
  return "";
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
  if (shape.cylinder)
    text += fmt::format(
        "cylinder through the base that fits best: radius {:.4g}, roughness {:.4g} ({:.1f} % of the "
        "distance)\n",
        shape.cylinder->radius * report.base, shape.cylinder->roughness * report.base,
        100 * shape.cylinder->roughness / shape.distance);
  for (const PairWeakness weakness : shape.weaknesses) text += sentence_of(weakness, report);
  return text;
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

std::string value(double v) { return fmt::format("{:.9g}", v); }

}  // namespace

std::string relative_text(const RelativeReport& report) {
  return head(report) + elements_text(report) + residuals_text(report) + distances_text(report) + shape_text(report);
}

std::string relative_summary_text(const RelativeReport& report, std::size_t most_rejected) {
  return head(report) + elements_text(report) + parallax_text(report) + rejection_text(report) +
         rejected_text(report, most_rejected) + distances_text(report) + shape_text(report);
}

TextTable relative_correlation_table(const RelativeReport& report) {
  TextTable table;
  table.remarks = {"element k: the k-th of its form"};
  table.columns = {{"form", ""}, {"element", ""}};
  for (int k = 1; k <= 5; ++k) table.columns.push_back({fmt::format("element_{}", k), ""});
  const auto add = [&](const char* form, const std::vector<Element>& elements, const Matrix5& c) {
    for (Eigen::Index i = 0; i < 5; ++i) {
      std::vector<std::string> row{form, elements[static_cast<std::size_t>(i)].name};
      for (Eigen::Index k = 0; k < 5; ++k) row.push_back(decimal_text(c(i, k) / std::sqrt(c(i, i) * c(k, k)), 6));
      table.rows.push_back(std::move(row));
    }
  };
  if (const auto d = dependent(report)) add("dependent", dependent_list(*d), d->covariance);
  const SymmetricWithCovariance s = symmetric(report);
  add("symmetric", symmetric_list(s), s.covariance);
  return table;
}

TextTable relative_parameter_table(const RelativeReport& report) {
  TextTable table;
  table.remarks = {"dependent pair: bx is the unit of by and bz; symmetric pair: omega1 = 0"};
  table.columns = {{"form", ""}, {"element", ""}, {"value", ""}, {"sigma", ""}, {"unit", ""}};
  const auto add = [&](const char* form, const std::vector<Element>& elements) {
    for (const Element& e : elements) table.rows.push_back({form, e.name, value(e.value), value(e.sigma), e.unit});
  };
  if (const auto d = dependent(report)) {
    table.rows.push_back({"dependent", "bx", value(d->elements.bx), "0", "1"});
    add("dependent", dependent_list(*d));
  }
  add("symmetric", symmetric_list(symmetric(report)));
  return table;
}

TextTable relative_residual_table(const RelativeReport& report) {
  const std::string unit(report.frame.unit());
  TextTable table;
  table.columns = {{"point", ""},       {"v_x_left", unit},  {"v_y_left", unit},
                   {"v_x_right", unit}, {"v_y_right", unit}, {"y_parallax", unit},
                   {"redundancy", ""},  {"test", ""},        {"used", ""}};
  const double weight = unit_weight(report);
  for (std::size_t i = 0; i < report.points.size(); ++i) {
    const PairResidual& residual = report.orientation.residuals[i];
    const Eigen::Vector4d v = residual_of(report, i);
    table.rows.push_back({report.names[i], value(v(0)), value(v(1)), value(v(2)), value(v(3)),
                          value(residual.y_parallax * report.frame.camera.focal_px()), value(residual.redundancy),
                          value(weight > 0 ? residual.standardised / weight : 0), residual.used ? "yes" : "no"});
  }
  return table;
}

TextTable relative_model_table(const RelativeReport& report) {
  const std::string unit = report.base_is_given ? "m" : "";
  TextTable table;
  table.remarks = {fmt::format("model coordinates: axes of the left image (x right, y up, z backwards), base {:g} {}",
                               report.base, unit)};
  table.columns = {{"point", ""},
                   {"U", unit},
                   {"V", unit},
                   {"W", unit},
                   {"sigma_U", unit},
                   {"sigma_V", unit},
                   {"sigma_W", unit},
                   {"correlation_UV", ""},
                   {"correlation_UW", ""},
                   {"correlation_VW", ""},
                   {"parallax", unit},
                   {"used", ""}};
  for (std::size_t i = 0; i < report.points.size(); ++i) {
    const auto& point = report.model.points[i];
    if (!point) continue;
    const Eigen::Vector3d& p = point->position;
    const Eigen::Matrix3d& c = point->covariance;
    const Eigen::Vector3d s = c.diagonal().cwiseMax(1e-300).cwiseSqrt();
    const double parallax = std::copysign(point->parallax.norm(), report.orientation.residuals[i].y_parallax);
    table.rows.push_back({report.names[i], value(p.x()), value(p.y()), value(p.z()), value(s.x()), value(s.y()),
                          value(s.z()), value(c(0, 1) / (s.x() * s.y())), value(c(0, 2) / (s.x() * s.z())),
                          value(c(1, 2) / (s.y() * s.z())), value(parallax),
                          report.orientation.residuals[i].used ? "yes" : "no"});
  }
  return table;
}

TextTable relative_exterior_table(const RelativeReport& report) {
  const std::string unit = report.base_is_given ? "m" : "";
  TextTable table;
  table.columns = {{"image", ""},    {"X", unit},    {"Y", unit},     {"Z", unit},
                   {"omega", "deg"}, {"phi", "deg"}, {"kappa", "deg"}};
  const Eigen::Vector3d& centre = report.model.second_centre.position;
  const Eigen::Quaterniond first_from_model(0, 1, 0, 0);
  const OmegaPhiKappa angles =
      omega_phi_kappa((report.orientation.second_from_first.rotation * first_from_model).normalized());
  table.rows.push_back({"left", "0", "0", "0", "0", "0", "0"});
  table.rows.push_back({"right", value(centre.x()), value(centre.y()), value(centre.z()), value(angles.omega_deg),
                        value(angles.phi_deg), value(angles.kappa_deg)});
  return table;
}

}  // namespace collinea
