// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace collinea {

/// One pointing to a mark.
struct MarkReading {
  std::string mark;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double sigma = 1;
};

/// A mark by all its readings.
struct ReadMark {
  std::string mark;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< weighted mean of the good ones
  double sigma = 1;                                    ///< of it, by those of the readings
  Eigen::Vector2d scatter = Eigen::Vector2d::Zero();   ///< standard deviation of one good reading; 0 of one alone
  int good = 0;
  std::vector<int> gross;     ///< which of its readings are wrong, from 1
  bool is_contested = false;  ///< readings differ beyond the limit, and no majority tells which are good: all are kept
};

struct ReadMarks {
  std::vector<ReadMark> marks;  ///< in the order in which they first come
  double sigma = 0;             ///< of one coordinate of a reading, pooled over good readings of all marks
  int degrees = 0;              ///< that it has
  double limit = 0;             ///< farther from the median of its mark a reading is gross
};

/// Repeated readings of marks. The limit is five times the spread about the medians of the marks (normalised median of
/// the absolute deviations of all marks with three readings and more), and five times `least_sigma` at least: readings
/// to whole pixels may agree exactly. A mark's readings within the limit of its median are good when they are more than
/// half of all.
[[nodiscard]] ReadMarks mean_of_readings(std::span<const MarkReading> readings, double least_sigma);

}  // namespace collinea
