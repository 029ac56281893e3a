// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/single_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/io/text.h"
#include "collinea/math/fisher.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

// So many digits behind the point that the standard deviation shows two.
int decimals_for(std::optional<double> sigma, double value) {
  if (!sigma || !std::isfinite(*sigma) || !(*sigma > 0)) {
    const double size = std::abs(value);
    return size > 0 && std::isfinite(size) ? std::clamp(6 - static_cast<int>(std::floor(std::log10(size))), 0, 12) : 6;
  }
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(*sigma))), 0, 12);
}

}  // namespace

std::string decimal_text(double value, int decimals) { return std::isfinite(value) ? fixed(value, decimals) : "-"; }

std::string estimate_text(double value, std::optional<double> sigma) {
  return decimal_text(value, decimals_for(sigma, value));
}

std::string sigma_text(std::optional<double> sigma) {
  return sigma && std::isfinite(*sigma) ? decimal_text(*sigma, decimals_for(sigma, *sigma)) : "-";
}

std::string estimates_text(std::span<const Estimate> estimates) {
  std::size_t name = 0, value = 0;
  for (const Estimate& e : estimates) {
    name = std::max(name, e.name.size());
    value = std::max(value, estimate_text(e.value, e.sigma).size());
  }
  std::string text;
  for (const Estimate& e : estimates) {
    text += fmt::format("  {:<{}}  {:>{}}", e.name, name, estimate_text(e.value, e.sigma), value);
    if (e.sigma) text += fmt::format("  +- {}", sigma_text(e.sigma));
    text += (e.unit.empty() ? "" : " " + e.unit) + "\n";
  }
  return text;
}

TextTable estimates_table(std::span<const Estimate> estimates) {
  TextTable table;
  table.columns = {{"parameter", ""}, {"value", ""}, {"sigma", ""}, {"unit", ""}};
  for (const Estimate& e : estimates)
    table.rows.push_back({e.name, exact(e.value), e.sigma ? exact(*e.sigma) : "-", e.unit.empty() ? "1" : e.unit});
  return table;
}

std::string correlations_text(std::span<const Estimate> estimates, const Eigen::MatrixXd& covariance, double least,
                              std::size_t most) {
  struct Pair {
    std::size_t i, j;
    double correlation;
  };
  std::vector<Pair> strong;
  for (std::size_t i = 0; i < estimates.size(); ++i)
    for (std::size_t j = i + 1; j < estimates.size(); ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      const double correlation = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
      if (std::abs(correlation) > least) strong.push_back({i, j, correlation});
    }
  std::stable_sort(strong.begin(), strong.end(),
                   [](const Pair& a, const Pair& b) { return std::abs(a.correlation) > std::abs(b.correlation); });
  std::string text;
  for (std::size_t k = 0; k < std::min(strong.size(), most); ++k)
    text += fmt::format("{}{} and {} {:+.3f}", k ? ", " : "", estimates[strong[k].i].name, estimates[strong[k].j].name,
                        strong[k].correlation);
  return text.empty() ? text : "strong correlations: " + text + "\n";
}

TextTable correlations_table(std::span<const Estimate> estimates, const Eigen::MatrixXd& covariance) {
  TextTable table;
  table.columns = {{"parameter", ""}};
  for (const Estimate& e : estimates) table.columns.push_back({e.name, ""});
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    std::vector<std::string> row{estimates[i].name};
    for (std::size_t j = 0; j < estimates.size(); ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      row.push_back(decimal_text(covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b)), 6));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

double VarianceTest::limit(std::size_t tests) const {
  const double each = alpha / double(std::max<std::size_t>(tests, 1));
  return sigmas_are_stated || redundancy <= 1 ? normal_limit(each) : tau_limit(each, redundancy);
}

double VarianceTest::limit_of_checks(std::size_t tests) const {
  const double each = alpha / double(std::max<std::size_t>(tests, 1));
  return sigmas_are_stated || redundancy <= 0 ? normal_limit(each) : student_limit(each, redundancy);
}

std::string largest_test_text(const VarianceTest& test, std::size_t tests, double largest, const std::string& point,
                              const std::string& image) {
  const double limit = test.limit(tests);
  return fmt::format("{}: largest |w| {:.2f} (point {}, {}), limit {:.2f}\n",
                     largest > limit ? "a measurement contradicts the others" : "no measurement contradicts the others",
                     largest, point, image, limit);
}

TextTable exterior_table(std::span<const std::string> images, std::span<const std::vector<Estimate>> exterior) {
  TextTable table;
  table.columns = {{"image", ""}};
  for (const char* prefix : {"", "sigma_"})
    for (const Estimate& e : exterior[0]) table.columns.push_back({prefix + e.name, e.unit});
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::vector<std::string> row{images[i]};
    for (const Estimate& e : exterior[i]) row.push_back(decimal_text(e.value, 8));
    for (const Estimate& e : exterior[i]) row.push_back(decimal_text(e.sigma.value_or(0), 8));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable exterior_table(std::span<const std::string> images, std::span<const std::vector<Estimate>> exterior,
                         std::span<const Eigen::Matrix<double, 6, 6>> covariances) {
  TextTable table = exterior_table(images, exterior);
  const auto digits = [](double value) { return fmt::format("{:.9g}", value); };
  for (std::size_t i = 1; i < 6; ++i)
    for (std::size_t k = 0; k < i; ++k)
      table.columns.push_back({fmt::format("correlation_{}_{}", exterior[0][k].name, exterior[0][i].name), ""});
  for (std::size_t row = 0; row < images.size(); ++row) {
    const Eigen::Matrix<double, 6, 6>& covariance = covariances[row];
    const Eigen::Matrix<double, 6, 1> sigmas = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    for (std::size_t k = 0; k < 6; ++k) table.rows[row][7 + k] = digits(sigmas(Eigen::Index(k)));
    for (Eigen::Index i = 1; i < 6; ++i)
      for (Eigen::Index k = 0; k < i; ++k) {
        const double product = sigmas(i) * sigmas(k);
        table.rows[row].push_back(digits(product > 0 ? covariance(i, k) / product : 0));
      }
  }
  return table;
}

std::string variance_text(const VarianceTest& test) {
  if (test.redundancy <= 0) return "redundancy 0: nothing checks the measurements, sigmas are those assumed for them\n";
  std::string text = fmt::format("sigma0 {:.4g}, redundancy {}", test.sigma0, test.redundancy);
  if (!test.sigmas_are_stated)
    return text + "; no standard deviations were stated: sigma0 is estimated and used in all sigmas\n";
  return text + "; " + verdict_text(test.verdict(), test.chance_of_more()) + "\n";
}

double VarianceTest::chance_of_more() const {
  return redundancy > 0 ? fisher_tail(sigma0 * sigma0, redundancy, INFINITY) : 1;
}

VarianceVerdict VarianceTest::verdict() const {
  if (redundancy <= 0 || !sigmas_are_stated) return VarianceVerdict::kNotTested;
  const double more = chance_of_more();
  return more < kLevel       ? VarianceVerdict::kTooLarge
         : more > 1 - kLevel ? VarianceVerdict::kTooSmall
                             : VarianceVerdict::kAgrees;
}

std::string verdict_text(VarianceVerdict verdict, double chance_of_more) {
  switch (verdict) {
    case VarianceVerdict::kTooLarge:
      return fmt::format("residuals are larger than the stated sigmas allow (chance of so much or more {:.1e})",
                         chance_of_more);
    case VarianceVerdict::kTooSmall:
      return "residuals are smaller than the stated sigmas let expect";
    case VarianceVerdict::kAgrees:
      return fmt::format("agrees with the stated sigmas (chance of so much or more {:.0f} %)", 100 * chance_of_more);
    case VarianceVerdict::kNotTested:
      break;
  }
  return "";
}

std::string indented_rows(const TextTable& table) {
  TextTable plain = table;
  plain.remarks.clear();
  std::string text;
  const std::string all = text_of(plain);
  for (const std::string_view line : lines_of(all))
    if (!line.empty()) text += "  " + std::string(line) + "\n";
  return text;
}

std::string counted_text(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace collinea
