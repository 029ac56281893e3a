// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace collinea {

/// What a piece of work costs this process: wall time, processor time of all threads and the largest memory held.
class CostMeter {
 public:
  CostMeter();  ///< starts; forgets the largest memory so far (where the system lets it)
  [[nodiscard]] double seconds() const;
  [[nodiscard]] double cpu_seconds() const;
  [[nodiscard]] double peak_memory_bytes() const;

 private:
  std::chrono::steady_clock::time_point start_;
  double cpu_start_s_ = 0;
};

}  // namespace collinea
