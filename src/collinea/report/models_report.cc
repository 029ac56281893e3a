// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/models_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "collinea/report/findings_text.h"
#include "collinea/report/internal/bundle_of_models_words.h"
#include "collinea/report/single_step.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kShown = 10;
constexpr double kPoorlyChecked = 0.1;  // redundancy numbers below it: a gross error hardly shows

std::string number(double value, const char* format = "{:.4f}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

Vector3d sigma_of(const JoinedPoint& point) { return point.covariance.diagonal().cwiseMax(0).cwiseSqrt(); }

struct Suspect {
  std::string what;
  char axis = ' ';
  CoordinateTest test;
};

std::vector<Suspect> suspects_of(const ModelsReport& report) {
  std::vector<Suspect> all;
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    if (!report.block.models[m]) continue;
    for (std::size_t i = 0; i < report.models[m].points.size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        all.push_back({"model " + report.models[m].name + ", point " + report.models[m].points[i].name, "UVW"[axis],
                       report.block.models[m]->tests[i][axis]});
  }
  for (const JoinedControl& one : report.block.control)
    for (std::size_t axis = 0; axis < 3; ++axis)
      all.push_back({"control " + report.control[one.index].name, "XYZ"[axis], one.tests[axis]});
  std::erase_if(all, [&](const Suspect& one) { return !(std::abs(one.test.w) > report.block.limit); });
  std::stable_sort(all.begin(), all.end(),
                   [](const Suspect& a, const Suspect& b) { return std::abs(a.test.w) > std::abs(b.test.w); });
  return all;
}

std::string counts_text(const ModelsReport& report) {
  const JoinedBlock& block = report.block;
  const auto joined =
      std::count_if(block.models.begin(), block.models.end(), [](const auto& m) { return m.has_value(); });
  int full = 0, plan = 0, height = 0, check = 0;
  for (const JoinedControl& one : block.control) {
    const SurveyedPoint& point = report.control[one.index];
    if (!one.seen) continue;
    if (point.is_check)
      ++check;
    else if (point.is_full())
      ++full;
    else
      ++(point.has_plan() ? plan : height);
  }
  std::string text =
      fmt::format("models        {} of {} joined, {} points\n", joined, block.models.size(), block.points.size());
  text += block.chain.on_ground ? fmt::format("control       {} full, {} in plan, {} in height; {} check points\n",
                                              full, plan, height, check)
                                : fmt::format("control       none: the frame is that of model {}\n",
                                              report.models[block.chain.reference].name);
  if (!report.chain_only)
    text += fmt::format(
        "counts        {} observations, {} unknowns (7 a model, 3 a point, less what is fixed), redundancy {}\n"
        "adjustment    spatially at once, {} steps\n",
        block.observations, block.unknowns, block.redundancy(), block.steps);
  std::map<int, int> shown;
  for (const JoinedPoint& point : block.points) ++shown[point.models];
  text += "observability ";
  for (const auto& [models, points] : shown)
    text += fmt::format("{}{} points in {}", models == shown.begin()->first ? "" : ", ", points,
                        models == 1 ? "one model" : fmt::format("{} models", models));
  return text + "\n";
}

// Of a chain: what its joins leave between the models.
std::string discrepancies_text(const ModelsReport& report) {
  const JoinedBlock& block = report.block;
  std::size_t links = 0, count = 0;
  for (const ChainPart& part : block.chain.parts) links += part.size() - 1;
  for (const JoinedPoint& point : block.points) count += point.models > 1 ? std::size_t(point.models) : 0;
  std::string text = fmt::format("chain         {} join{}, no adjustment\n", links, links == 1 ? "" : "s");
  if (!std::isfinite(block.sigma0)) return text + "sigma0        none: no point is in two models\n";
  return text +
         fmt::format("sigma0        {:.4g} of {} discrepancies of {:.4g} {} (RMS of model minus mean, in space){}\n",
                     block.sigma0, count, std::sqrt(block.squares / double(count)), report.ground_unit(),
                     report.sigmas_known ? "" : ": all standard deviations are multiplied by it");
}

std::string sigma0_text(const ModelsReport& report) {
  const JoinedBlock& block = report.block;
  if (report.chain_only) return discrepancies_text(report);
  if (block.redundancy() <= 0) return "sigma0        none: nothing is redundant, nothing is checked\n";
  std::string text = fmt::format("sigma0        {:.4g}", block.sigma0);
  if (report.sigma_guessed)
    text += fmt::format(
        " of coordinates with {:.3g} {}, which was assumed: their sigma is {:.3g}; all standard "
        "deviations are multiplied by it\n",
        *report.sigma_guessed, report.model_unit, block.sigma0 * *report.sigma_guessed);
  else if (!report.sigmas_known)
    text += ": all standard deviations are multiplied by it\n";
  else
    text += fmt::format(": {} (chance of so much or more {:.2g})\n",
                        block.chance < VarianceTest::kLevel        ? "residuals are larger than the sigmas allow"
                        : block.chance <= 1 - VarianceTest::kLevel ? "residuals agree with the sigmas"
                        : report.pairs.empty()
                            ? "residuals are smaller than the sigmas say"
                            : "residuals are smaller than the sigmas say, as those of models with images in common are",
                        block.chance);
  return text;
}

std::string accuracy_text(const ModelsReport& report) {
  Vector3d squares = Vector3d::Zero(), worst = Vector3d::Zero(), apart = Vector3d::Zero();
  Vector3d apart_in_sigmas = Vector3d::Zero(), ratio = Vector3d::Zero();
  for (const JoinedPoint& point : report.block.points) {
    const Vector3d sigma = sigma_of(point);
    squares += sigma.cwiseAbs2();
    worst = worst.cwiseMax(sigma);
    if (!report.anblock) continue;
    const AnblockPoint& other = report.anblock->points.at(point.name);
    const Vector3d difference = other.position - point.position;
    apart += difference.cwiseAbs2();
    for (int axis = 0; axis < 3; ++axis)
      if (sigma[axis] > 0) {
        apart_in_sigmas[axis] += std::pow(difference[axis] / sigma[axis], 2);
        ratio[axis] += other.sigma[axis] / sigma[axis] / double(report.block.points.size());
      }
  }
  const double n = double(std::max<std::size_t>(report.block.points.size(), 1));
  const Vector3d rms = (squares / n).cwiseSqrt();
  const std::string unit = report.ground_unit();
  std::string text =
      fmt::format("points        sigma X {:.4g}, Y {:.4g}, Z {:.4g} {} (RMS); at most {:.4g}, {:.4g}, {:.4g}\n",
                  rms.x(), rms.y(), rms.z(), unit, worst.x(), worst.y(), worst.z());
  if (!report.anblock_failure.empty()) text += "anblock       none: " + report.anblock_failure + "\n";
  if (!report.anblock) return text;
  apart = (apart / n).cwiseSqrt();
  apart_in_sigmas = (apart_in_sigmas / n).cwiseSqrt();
  const AnblockCycle& last = report.anblock->cycles.back();
  text += fmt::format(
      "anblock       {} cycles; sigma0 in plan {:.4g} (redundancy {}), in height {:.4g} ({})\n"
      "              differs by X {:.4g}, Y {:.4g}, Z {:.4g} {} (RMS), {:.2f}, {:.2f}, {:.2f} sigma; its sigmas are "
      "{:.2f}, {:.2f}, {:.2f} of these\n",
      report.anblock->cycles.size(), last.plan_sigma0, report.anblock->plan_redundancy, last.height_sigma0,
      report.anblock->height_redundancy, apart.x(), apart.y(), apart.z(), unit, apart_in_sigmas.x(),
      apart_in_sigmas.y(), apart_in_sigmas.z(), ratio.x(), ratio.y(), ratio.z());
  return text;
}

std::string indented_text(const TextTable& table) {
  std::string text = "  ";
  for (const char c : text_of(table)) text += c == '\n' ? "\n  " : std::string(1, c);
  text.resize(text.size() - 2);
  return text;
}

std::string unseen_control_text(const ModelsReport& report) {
  std::string text;
  for (const JoinedControl& one : report.block.control)
    if (!one.seen) text += fmt::format("control {} is in no model\n", report.control[one.index].name);
  return text;
}

// What a gross error could hide in (Mussio 4.3.7: a check of redundancy, global and local).
std::string weak_text(const ModelsReport& report) {
  std::string text;
  std::size_t poor = 0, coordinates = 0;
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    if (!report.block.models[m]) continue;
    const JoinedModel& model = *report.block.models[m];
    for (std::size_t i = 0; i < model.tests.size(); ++i)
      for (const CoordinateTest& test : model.tests[i]) {
        ++coordinates;
        poor += test.redundancy < kPoorlyChecked ? 1 : 0;
      }
  }
  if (poor > 0)
    text += fmt::format(
        "{} of {} model coordinates have a redundancy number below {}: gross errors in them hardly "
        "show\n",
        poor, coordinates, kPoorlyChecked);
  return text + unseen_control_text(report);
}

}  // namespace

std::string models_text(const ModelsReport& report) {
  std::string text;
  if (!report.pairs.empty()) {
    double squares = 0;
    int formed = 0, rejected = 0;
    for (const FormedModel& pair : report.pairs)
      if (pair.failure.empty()) {
        ++formed;
        rejected += pair.rejected;
        squares += pair.sigma0 * pair.sigma0;
      }
    text += fmt::format("pairs         {} of {} oriented, sigma0 {:.3g} (RMS), {} points rejected\n", formed,
                        report.pairs.size(), std::sqrt(squares / std::max(formed, 1)), rejected);
  }
  text += counts_text(report) + sigma0_text(report) + accuracy_text(report);
  if (report.bundle) text += bundle_text(report.block, *report.bundle);
  if (!report.block.control.empty())
    text += std::string("\ncontrol, given minus ") + (report.chain_only ? "chain\n" : "adjusted\n") +
            indented_text(joined_control_table(report));
  if (report.chain_only) return text + unseen_control_text(report) + findings_text(report.findings);
  const std::vector<Suspect> suspects = suspects_of(report);
  text += fmt::format("\n{} coordinates are suspect (|w| > {:.2f})\n", suspects.size(), report.block.limit);
  for (std::size_t i = 0; i < std::min(kShown, suspects.size()); ++i)
    text += fmt::format("  {} {}: w {:.1f}, residual {:.4g}, redundancy {:.2f}{}\n", suspects[i].what, suspects[i].axis,
                        suspects[i].test.w, suspects[i].test.residual, suspects[i].test.redundancy,
                        i == 0 ? "  (the worst: believe it alone)" : "");
  if (suspects.size() > kShown) text += fmt::format("  and {} more\n", suspects.size() - kShown);
  return text + weak_text(report) + findings_text(report.findings);
}

TextTable joined_point_table(const ModelsReport& report) {
  const std::string unit = report.ground_unit();
  TextTable table;
  table.columns = {{"point", ""},
                   {"X", unit},
                   {"Y", unit},
                   {"Z", unit},
                   {"sigma_X", unit},
                   {"sigma_Y", unit},
                   {"sigma_Z", unit},
                   {"correlation_XY", ""},
                   {"correlation_XZ", ""},
                   {"correlation_YZ", ""},
                   {"models", ""}};
  if (report.anblock)
    for (const char* name :
         {"anblock_X", "anblock_Y", "anblock_Z", "anblock_sigma_X", "anblock_sigma_Y", "anblock_sigma_Z"})
      table.columns.push_back({name, unit});
  if (report.bundle) add_bundle_columns(table);
  for (const JoinedPoint& point : report.block.points) {
    const Vector3d s = sigma_of(point);
    const auto correlation = [&](int a, int b) {
      return s[a] > 0 && s[b] > 0 ? number(point.covariance(a, b) / (s[a] * s[b]), "{:.3f}") : "-";
    };
    std::vector<std::string> row = {point.name};
    for (int axis = 0; axis < 3; ++axis) row.push_back(number(point.position[axis], "{:.5f}"));
    for (int axis = 0; axis < 3; ++axis) row.push_back(number(s[axis], "{:.3g}"));
    row.insert(row.end(), {correlation(0, 1), correlation(0, 2), correlation(1, 2), std::to_string(point.models)});
    if (report.anblock) {
      const AnblockPoint& other = report.anblock->points.at(point.name);
      for (int axis = 0; axis < 3; ++axis) row.push_back(number(other.position[axis], "{:.5f}"));
      for (int axis = 0; axis < 3; ++axis) row.push_back(number(other.sigma[axis], "{:.3g}"));
    }
    if (report.bundle) add_bundle_fields(point, *report.bundle, row);
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable joined_model_table(const ModelsReport& report) {
  const std::string unit = report.ground_unit();
  TextTable table;
  table.remarks = {
      "X, Y, Z: origin of the model on the ground; ground = scale Rx(omega) Ry(phi) Rz(kappa) model + origin"};
  table.columns = {{"model", ""}};
  const std::pair<const char*, std::string> parameters[7] = {
      {"X", unit}, {"Y", unit}, {"Z", unit}, {"omega", "deg"}, {"phi", "deg"}, {"kappa", "deg"}, {"scale", ""}};
  for (const auto& [name, its_unit] : parameters) table.columns.push_back({name, its_unit});
  for (const auto& [name, its_unit] : parameters) table.columns.push_back({std::string("sigma_") + name, its_unit});
  table.columns.push_back({"redundancy", ""});
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    if (!report.block.models[m]) continue;
    const JoinedModel& model = *report.block.models[m];
    const Vector3d& t = model.ground_from_model.translation;
    const double values[7] = {t.x(),
                              t.y(),
                              t.z(),
                              model.omega_rad * kDegrees,
                              model.phi_rad * kDegrees,
                              model.kappa_rad * kDegrees,
                              model.ground_from_model.scale};
    std::vector<std::string> row = {report.models[m].name};
    for (int i = 0; i < 7; ++i) row.push_back(number(values[i], i < 3 ? "{:.4f}" : i < 6 ? "{:.6f}" : "{:.8g}"));
    for (int i = 0; i < 7; ++i)
      row.push_back(
          number(std::sqrt(std::max(0.0, model.covariance(i, i))) * (i > 2 && i < 6 ? kDegrees : 1), "{:.3g}"));
    row.push_back(number(model.redundancy, "{:.2f}"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable model_residual_table(const ModelsReport& report) {
  const std::string& unit = report.model_unit;
  TextTable table;
  table.columns = {{"model", ""}, {"point", ""}, {"v_U", unit}, {"v_V", unit}, {"v_W", unit}, {"r_U", ""},
                   {"r_V", ""},   {"r_W", ""},   {"w_U", ""},   {"w_V", ""},   {"w_W", ""}};
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    if (!report.block.models[m]) continue;
    for (std::size_t i = 0; i < report.models[m].points.size(); ++i) {
      const auto& tests = report.block.models[m]->tests[i];
      std::vector<std::string> row = {report.models[m].name, report.models[m].points[i].name};
      for (const CoordinateTest& test : tests) row.push_back(number(test.residual, "{:.4g}"));
      for (const CoordinateTest& test : tests) row.push_back(number(test.redundancy, "{:.3f}"));
      for (const CoordinateTest& test : tests) row.push_back(number(test.w, "{:.2f}"));
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

TextTable joined_control_table(const ModelsReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"role", ""}, {"dX", "m"}, {"dY", "m"}, {"dZ", "m"}, {"r_X", ""},
                   {"r_Y", ""},   {"r_Z", ""},  {"w_X", ""}, {"w_Y", ""}, {"w_Z", ""}};
  for (const JoinedControl& one : report.block.control) {
    const SurveyedPoint& point = report.control[one.index];
    if (!one.seen) continue;
    std::vector<std::string> row = {point.name, point.is_check ? "check" : "control"};
    for (int axis = 0; axis < 3; ++axis) row.push_back(number(one.difference[axis]));
    const auto tested = [&](int axis) { return point.has(axis) && point.sigma[axis] > 0 && !point.is_check; };
    for (int axis = 0; axis < 3; ++axis)
      row.push_back(tested(axis) ? number(one.tests[static_cast<std::size_t>(axis)].redundancy, "{:.2f}") : "-");
    for (int axis = 0; axis < 3; ++axis) {
      const double w =
          point.is_check ? one.difference[axis] / one.sigma[axis] : one.tests[static_cast<std::size_t>(axis)].w;
      row.push_back(tested(axis) || point.is_check ? number(w, "{:.2f}") : "-");
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable formed_model_table(const ModelsReport& report) {
  const std::string& unit = report.model_unit;
  TextTable table;
  table.columns = {{"model", ""}, {"point", ""},     {"U", unit},       {"V", unit},
                   {"W", unit},   {"sigma_U", unit}, {"sigma_V", unit}, {"sigma_W", unit}};
  for (const StereoModel& model : report.models)
    for (const NamedPoint& point : model.points) {
      std::vector<std::string> row = {model.name, point.name};
      for (int axis = 0; axis < 3; ++axis) row.push_back(number(point.position[axis], "{:.10g}"));
      for (int axis = 0; axis < 3; ++axis)
        row.push_back(number(std::sqrt(std::max(0.0, point.covariance(axis, axis))), "{:.6g}"));
      table.rows.push_back(std::move(row));
    }
  return table;
}

TextTable formed_covariance_table(const ModelsReport& report) {
  TextTable table;
  for (const char* name : {"model", "point", "other", "UU", "UV", "UW", "VU", "VV", "VW", "WU", "WV", "WW"})
    table.columns.push_back({name, ""});
  for (const StereoModel& model : report.models)
    for (std::size_t i = 0; i < model.points.size() && model.covariance.size() > 0; ++i)
      for (std::size_t k = 0; k <= i; ++k) {
        std::vector<std::string> row = {model.name, model.points[i].name, model.points[k].name};
        for (int e = 0; e < 9; ++e)
          row.push_back(number(
              model.covariance(static_cast<Eigen::Index>(3 * i) + e / 3, static_cast<Eigen::Index>(3 * k) + e % 3),
              "{:.12g}"));
        table.rows.push_back(std::move(row));
      }
  return table;
}

}  // namespace collinea
