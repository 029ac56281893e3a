// SPDX-License-Identifier: Apache-2.0
// Tables of a relative orientation.
#include <array>
#include <cmath>

#include "collinea/report/internal/relative_values.h"
#include "collinea/report/relative_report.h"
#include "collinea/report/single_step.h"

namespace collinea {

using namespace relative;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::array<const char*, 6> kPoseNames = {"X", "Y", "Z", "omega", "phi", "kappa"};

}  // namespace

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
  std::array<std::vector<Estimate>, 2> elements;
  for (std::size_t k = 0; k < 6; ++k) {
    elements[0].push_back({kPoseNames[k], k < 3 ? unit : "deg", 0});
    elements[1].push_back({kPoseNames[k], k < 3 ? unit : "deg", report.right_pose(Eigen::Index(k))});
  }
  const std::array<std::string, 2> images{"left", "right"};
  const std::array<Matrix6, 2> covariances{Matrix6::Zero(), report.right_covariance};
  TextTable table = exterior_table(images, elements, covariances);
  table.remarks = {"the left image is without error; the length of the base, too, unless distances gave it"};
  return table;
}

TextTable relative_correlation_table(const RelativeReport& report) {
  TextTable table;
  table.columns = {{"form", ""}, {"element", ""}, {"other", ""}, {"correlation", ""}};
  const auto add = [&](const char* form, const std::vector<Element>& elements, const Matrix5& covariance) {
    for (std::size_t i = 1; i < elements.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        table.rows.push_back({form, elements[k].name, elements[i].name,
                              value(correlation_of(covariance, Eigen::Index(i), Eigen::Index(k)))});
  };
  if (const auto d = dependent(report)) add("dependent", dependent_list(*d), d->covariance);
  const SymmetricWithCovariance s = symmetric(report);
  add("symmetric", symmetric_list(s), s.covariance);
  return table;
}

TextTable relative_linear_table(const RelativeReport& report) {
  TextTable table;
  table.columns = {{"element", ""}, {"linear", ""}, {"sigma", ""}, {"rigorous", ""}, {"difference", ""}, {"unit", ""}};
  const auto d = dependent_elements(report.orientation.second_from_first);
  if (!report.linear || !d) return table;
  const LinearOrientation& linear = *report.linear;
  const double of_unit = report.options.sigma_known || linear.redundancy == 0 ? 1 : linear.sigma0;
  DependentElements rigorous = *d;  // over bx, as the linear equations have them
  rigorous.by *= d->bx;
  rigorous.bz *= d->bx;
  const auto list = dependent_list({linear.elements, linear.covariance * of_unit * of_unit}),
             others = dependent_list({rigorous, Matrix5::Zero()});
  for (std::size_t k = 0; k < list.size(); ++k)
    table.rows.push_back({list[k].name, value(list[k].value), value(list[k].sigma), value(others[k].value),
                          value(list[k].value - others[k].value), list[k].unit});
  return table;
}

TextTable relative_linear_parallax_table(const RelativeReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"parallax", std::string(report.frame.unit())}};
  if (!report.linear) return table;
  std::size_t k = 0;
  for (std::size_t i = 0; i < report.names.size(); ++i)
    if (report.orientation.residuals[i].used)
      table.rows.push_back({report.names[i], value(report.linear->parallaxes[k++] * report.frame.camera.focal_px())});
  return table;
}

TextTable relative_search_table(const RelativeReport& report) {
  TextTable table;
  table.remarks = {"misclosure: root mean square of unit rays and a unit base"};
  table.columns = {{"solution", ""}, {"form", ""}, {"element", ""}, {"value", ""}, {"unit", ""}};
  const auto& search = report.orientation.search;
  if (!search) return table;
  const auto count = [&](const char* name, double of) { table.rows.push_back({"-", "search", name, value(of), "1"}); };
  count("starts", search->starts);
  count("converged", search->converged);
  count("distinct", double(search->distinct.size()));
  count("misclosure", search->rms);
  for (std::size_t k = 0; k < search->distinct.size(); ++k) {
    const std::string solution = std::to_string(k + 1);
    if (const auto d = dependent_elements(search->distinct[k])) {
      table.rows.push_back({solution, "dependent", "bx", value(d->bx), "1"});
      for (const Element& e : dependent_list({*d, Matrix5::Zero()}))
        table.rows.push_back({solution, "dependent", e.name, value(e.value), e.unit});
    }
    for (const Element& e : symmetric_list({symmetric_elements(search->distinct[k]), Matrix5::Zero()}))
      table.rows.push_back({solution, "symmetric", e.name, value(e.value), e.unit});
  }
  return table;
}

TextTable relative_coplanarity_table(const RelativeReport& report) {
  const std::string unit = report.base_is_given ? "m" : "", of_image(report.frame.unit());
  TextTable table;
  table.remarks = {
      "coplanarity condition, rays (x, y, -c) in units of c: dependent with bx = +-1, symmetric with a base of length "
      "1, "
      "exterior with the base as it is; sigma of symmetric; gap: shortest change of the four coordinates; w = "
      "symmetric "
      "over sigma"};
  table.columns = {{"point", ""}, {"dependent", ""}, {"symmetric", ""}, {"exterior", unit},
                   {"sigma", ""}, {"gap", of_image}, {"w", ""}};
  if (!report.coplanarity) return table;
  for (std::size_t i = 0; i < report.names.size(); ++i) {
    const PointCoplanarity& one = report.coplanarity->points[i];
    table.rows.push_back({report.names[i], one.dependent ? value(*one.dependent) : "-", value(one.symmetric),
                          value(one.exterior), value(one.sigma), value(one.gap * report.frame.camera.focal_px()),
                          value(one.w)});
  }
  return table;
}

TextTable relative_solutions_table(const RelativeReport& report) {
  TextTable table;
  table.columns = {{"solution", ""}, {"form", ""}, {"element", ""}, {"value", ""}, {"unit", ""}, {"in_front", ""}};
  for (std::size_t k = 0; k < report.solutions.size(); ++k) {
    const auto add = [&](const char* form, const std::string& name, double v, const std::string& unit) {
      table.rows.push_back(
          {std::to_string(k + 1), form, name, value(v), unit, std::to_string(report.solutions[k].in_front)});
    };
    if (const auto d = dependent_elements(report.solutions[k].second_from_first)) {
      add("dependent", "bx", d->bx, "1");
      for (const Element& e : dependent_list({*d, Matrix5::Zero()})) add("dependent", e.name, e.value, e.unit);
    }
    const SymmetricElements s = symmetric_elements(report.solutions[k].second_from_first);
    for (const Element& e : symmetric_list({s, Matrix5::Zero()})) add("symmetric", e.name, e.value, e.unit);
  }
  return table;
}

}  // namespace collinea
