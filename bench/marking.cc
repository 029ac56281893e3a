// SPDX-License-Identifier: Apache-2.0
// Time of the adjustment after each mark of a control point, in a block of 500 images: at the beginning, and the median
// and largest of the marks.   collinea_bench_marking [ROWS COLUMNS]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "collinea/adjust/test_block.h"
#include "collinea/quality/marked_points.h"

namespace {

using namespace collinea;

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

constexpr int kPoints = 10, kMarks = 6;

}  // namespace

int main(int argc, char** argv) {
  const int rows = argc > 2 ? std::atoi(argv[1]) : 20, columns = argc > 2 ? std::atoi(argv[2]) : 25;
  const Block block = testing::test_block({.rows = rows,
                                           .columns = columns,
                                           .points = 60 * rows * columns,
                                           .sigma_px = 0.5,
                                           .position_sigma_m = 0.05,
                                           .control = kPoints});
  AdjustOptions options;
  options.calibration = Calibration::kBrown;
  const double before = seconds();
  Result<MarkedBlock> base = MarkedBlock::of(block, {}, options, BlockControl::kLeftOut, {});
  if (!base) return std::printf("%s\n", base.error().message.c_str()), 1;
  std::printf("%zu images, %zu observations: at the beginning %.2f s\n", block.images.size(), block.observations.size(),
              seconds() - before);
  std::vector<BlockPoint> points;
  std::vector<double> wall, cpu;
  for (const auto& [id, control] : block.control) {
    points.push_back({{}, SurveyedPosition{control.position_in_world, control.sigma_m, {0, 0, 0}, control.role}});
    for (const ControlObservation& seen : block.control_observations) {
      if (seen.point != id || points.back().marks.size() == kMarks) continue;
      points.back().marks.push_back({seen.image, seen.pixel, seen.sigma_px});
      const double start = seconds();
      const std::clock_t start_cpu = std::clock();
      if (!base->adjust(points)) return std::puts("not adjusted"), 1;
      wall.push_back(seconds() - start);
      cpu.push_back(double(std::clock() - start_cpu) / CLOCKS_PER_SEC);
    }
  }
  for (auto* times : {&wall, &cpu}) {
    std::sort(times->begin(), times->end());
    std::printf("%zu marks, %s: median %.1f ms, largest %.1f ms\n", times->size(), times == &wall ? "clock" : "CPU",
                1e3 * (*times)[times->size() / 2], 1e3 * times->back());
  }
}
