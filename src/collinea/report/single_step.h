// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/io/text_table.h"

namespace collinea {

// What the commands of one method have in common: estimates with standard deviations, the test of the whole and of
// each measurement, tables.

/// A quantity as it was estimated.
struct Estimate {
  std::string name, unit;
  double value = 0;
  std::optional<double> sigma = {};  ///< nothing: none can be stated
};

/// A value with so many digits that its standard deviation shows two, and the standard deviation.
[[nodiscard]] std::string estimate_text(double value, std::optional<double> sigma);
[[nodiscard]] std::string sigma_text(std::optional<double> sigma);
/// A line each, columns aligned, indented_rows by two blanks.
[[nodiscard]] std::string estimates_text(std::span<const Estimate> estimates);
/// Columns parameter, value, sigma, unit.
[[nodiscard]] TextTable estimates_table(std::span<const Estimate> estimates);

/// A row an image: its exterior orientation, and the standard deviations (0 where there are none).
[[nodiscard]] TextTable exterior_table(std::span<const std::string> images,
                                       std::span<const std::vector<Estimate>> exterior);
/// The same with standard deviations and correlations (correlation_X_Y and so on) by the covariances of the elements;
/// 0 where they are exact.
[[nodiscard]] TextTable exterior_table(std::span<const std::string> images,
                                       std::span<const std::vector<Estimate>> exterior,
                                       std::span<const Eigen::Matrix<double, 6, 6>> covariances);

/// The matrix of correlations of estimates in their order, from a covariance: those beyond `least` in words, the
/// strongest first, at most `most`.
[[nodiscard]] std::string correlations_text(std::span<const Estimate> estimates, const Eigen::MatrixXd& covariance,
                                            double least = 0.7, std::size_t most = 6);
/// Columns parameter and one for each estimate.
[[nodiscard]] TextTable correlations_table(std::span<const Estimate> estimates, const Eigen::MatrixXd& covariance);

/// Whether residuals agree with the standard deviations that were stated. What has a chance below the level of the test
/// is no agreement.
enum class VarianceVerdict : std::uint8_t { kNotTested, kAgrees, kTooLarge, kTooSmall };

/// The variance of unit weight against the standard deviations of the measurements.
struct VarianceTest {
  double sigma0 = 1;
  int redundancy = 0;
  bool sigmas_are_stated = false;  ///< otherwise sigma0 is what they are multiplied by
  double alpha = 0.001;

  /// By what stated standard deviations are multiplied: 1 where they stand for themselves.
  [[nodiscard]] double factor() const { return sigmas_are_stated || redundancy <= 0 ? 1 : sigma0; }
  /// By what tests are divided: factor(), or 1 where residuals are those of rounding (below a millionth of the assumed
  /// standard deviations): nothing of them is tested then.
  [[nodiscard]] double of_tests() const { return factor() < 1e-6 ? 1 : factor(); }
  /// Of the test w of one measurement, divided by of_tests(): normal, or tau. Of the largest of `tests` together that
  /// chance makes larger is `alpha` at most (Bonferroni: alpha / tests for each).
  [[nodiscard]] double limit(std::size_t tests = 1) const;
  /// Of a deviation over its standard deviation of what took no part in the adjustment: normal, or Student's t, for its
  /// error and sigma0 are independent.
  [[nodiscard]] double limit_of_checks(std::size_t tests = 1) const;

  /// Level of the test of sigma0 as a whole, each way.
  static constexpr double kLevel = 0.01;
  /// That sigma0 is as large or larger (smaller), if the stated standard deviations are right.
  [[nodiscard]] double chance_of_more() const;
  [[nodiscard]] double chance_of_less() const { return 1 - chance_of_more(); }
  [[nodiscard]] VarianceVerdict verdict() const;
};
/// The outcome for people, where standard deviations were stated: "agrees with the stated sigmas (chance ...)".
[[nodiscard]] std::string verdict_text(VarianceVerdict verdict, double chance_of_more);
[[nodiscard]] std::string variance_text(const VarianceTest& test);
/// The largest of `tests` of measurements beside the limit of all together, and whether it contradicts the others.
[[nodiscard]] std::string largest_test_text(const VarianceTest& test, std::size_t tests, double largest,
                                            const std::string& point, const std::string& image);

/// The rows of a table indented_rows by two blanks, without remarks.
[[nodiscard]] std::string indented_rows(const TextTable& table);
[[nodiscard]] std::string decimal_text(double value, int decimals);  ///< "-" where it is not finite

/// "1 point", "3 points".
[[nodiscard]] std::string counted_text(std::size_t count, const std::string& noun);

/// A table under the name of its file.
struct NamedTable {
  std::string name;
  TextTable table;
};

}  // namespace collinea
