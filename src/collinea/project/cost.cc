// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/cost.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace collinea {
namespace {

double cpu_now_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

CostMeter::CostMeter() : start_(std::chrono::steady_clock::now()), cpu_start_s_(cpu_now_s()) {
  std::ofstream("/proc/self/clear_refs") << "5";  // resets VmHWM
}

double CostMeter::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

double CostMeter::cpu_seconds() const { return cpu_now_s() - cpu_start_s_; }

double CostMeter::peak_memory_bytes() const {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::stod(line.substr(6));
  return 0;
}

}  // namespace collinea
