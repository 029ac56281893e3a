// SPDX-License-Identifier: Apache-2.0
// What systematic errors the block of an adjustment file shows: one line for each hypothesis, and the findings.
//
// usage: collinea_bench_systematics_file FILE [threads]     (a file of collinea adjust PROJECT --export FILE
// --time-offset)
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <string>

#include "collinea/base/file.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/orient/flight_strips.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/systematic_findings.h"
#include "collinea/report/finding_words.h"

namespace collinea {
namespace {

AdjustScope scope_of(const AdjustmentFile& file) {
  AdjustScope scope;
  scope.fixed_images = file.fixed_images;
  scope.first_cameras = file.given_cameras;
  scope.camera_sigmas = file.camera_sigmas;
  scope.corrected_cameras = file.corrected_cameras;
  static_cast<Instruments&>(scope) = file.instruments;
  scope.time_offset_sigma_s.clear();
  return scope;
}

void print(const std::vector<SystematicTest>& tests, const Block& block) {
  for (const SystematicTest& test : tests) {
    std::string values;
    for (std::size_t k = 0; k < std::min<std::size_t>(3, test.values.size()); ++k)
      values += fmt::format(" {:.4g}+-{:.2g}", test.values[k], test.sigmas[k]);
    fmt::print("{:<16}{:<11}{:<6}{:>10.1f} /{:>3}  p {:.1e} {:.1e} {}{}  effect {:.3g} {}  ground {:.4f} m {}{}:{}\n",
               word_of(test.kind), word_of(test.additional), test.strip ? fmt::format("{}", *test.strip) : "",
               test.statistic, test.degrees, test.p_value, test.p_corrected, test.significant ? "*" : " ",
               test.determined ? "" : "(not determined)", test.largest_effect, test.effect_unit, test.ground_change_m,
               test.explained_by ? fmt::format("by {}", *test.explained_by) : "", test.unit, values);
  }
  for (const Finding& finding : systematic_findings(tests, block)) fmt::print("{}\n", what_of(finding, block));
}

int look(const std::string& path, int threads) {
  const auto text = read_file(path);
  if (!text) return 2;
  auto file = parse_adjustment_file(*text);
  if (!file) {
    fmt::print(stderr, "{}\n", file.error().message);
    return 2;
  }
  Run run;
  run.threads = threads;
  ExamineOptions options;
  const auto timed = [&](bool test) {
    options.systematics.test = test;
    const auto start = std::chrono::steady_clock::now();
    auto examined = examine(file->block, scope_of(*file), options, run);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    fmt::print("{} {:.2f} s\n", test ? "with systematic errors" : "without", took.count());
    return examined;
  };
  for (const FlightStrip& strip : flight_strips(file->block)) options.systematics.strips.push_back(strip);
  options.systematics.velocity_m_s = flight_velocities(file->block);
  static_cast<void>(timed(false));
  const auto examined = timed(true);
  if (!examined) {
    fmt::print(stderr, "{}\n", examined.error().message);
    return 2;
  }
  fmt::print("sigma0 {:.3f}, redundancy {}, {} strips\n", examined->sigma0, examined->redundancy,
             options.systematics.strips.size());
  print(examined->systematics, file->block);
  return 0;
}

}  // namespace
}  // namespace collinea

int main(int argc, char** argv) { return argc < 2 ? 2 : collinea::look(argv[1], argc > 2 ? std::atoi(argv[2]) : 2); }
