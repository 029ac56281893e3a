// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/measure_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "collinea/base/file.h"
#include "collinea/base/nearest_names.h"
#include "collinea/block/world_frame.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/asked_figures.h"
#include "collinea/project/adjustment_task.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Points in the order of their first marks.
struct MarkTable {
  std::vector<std::string> names;
  std::vector<BlockPoint> points;
};

Result<MarkTable> read_marks(const std::filesystem::path& file, const Block& block, double sigma_px) {
  COLLINEA_TRY(const TextTable table, read_text_table(file));
  const auto read = [&]() -> Result<MarkTable> {
    COLLINEA_TRY(const auto images, table.words("image"));
    COLLINEA_TRY(const auto points, table.words("point"));
    COLLINEA_TRY(const auto x, table.numbers("x", "px"));
    COLLINEA_TRY(const auto y, table.numbers("y", "px"));
    COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", "px", sigma_px));
    std::map<std::string, ImageId> ids;
    std::vector<std::string> files;
    for (const auto& [id, image] : block.images) {
      ids[image.file] = id;
      files.push_back(image.file);
    }
    MarkTable out;
    std::map<std::string, std::size_t> numbers;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto image = ids.find(images[i]);
      if (image == ids.end())
        return tl::unexpected(
            with_nearest(Error{Errc::kBadInput, fmt::format("row {}: there is no image \"{}\"", i + 1, images[i])},
                         images[i], files));
      if (!(sigmas[i] > 0)) return fail(Errc::kBadInput, fmt::format("row {}: sigma is not above 0", i + 1));
      const auto [its, is_new] = numbers.try_emplace(points[i], out.points.size());
      if (is_new) {
        out.names.push_back(points[i]);
        out.points.emplace_back();
      }
      out.points[its->second].marks.push_back({image->second, {x[i], y[i]}, sigmas[i]});
    }
    if (out.points.empty()) return fail(Errc::kBadInput, "there are no marks");
    return out;
  };
  return read().map_error([&](Error e) { return std::move(e).within(file.string()); });
}

// Positions in the map where the block has one, and covariances turned to it.
Result<void> take_positions(const Block& block, const AdjustedMarks& adjusted, MeasuredReport& report,
                            std::vector<double>& heights) {
  COLLINEA_TRY(const auto frame, world_frame(block));
  if (frame) report.crs = frame->crs();
  for (std::size_t i = 0; i < report.points.size(); ++i) {
    const AdjustedMark& mark = adjusted.points[i];
    if (!mark.position_in_world) continue;
    MeasuredReport::Point& point = report.points[i];
    point.position = frame ? frame->map_from_local(*mark.position_in_world) : *mark.position_in_world;
    const Eigen::Matrix3d turn = frame ? map_from_local_rotation(*frame, *mark.position_in_world).toRotationMatrix()
                                       : Eigen::Matrix3d::Identity();
    point.covariance = turn * mark.covariance_m2 * turn.transpose();
    heights.push_back(point.position->z());
  }
  return {};
}

Result<void> measure_figures(const MarkTable& table, const AdjustedMarks& adjusted, std::vector<double> heights,
                             MeasuredReport& report) {
  FigurePoints points{{}, std::move(heights), adjusted.covariance_m2};
  std::map<std::string, std::optional<std::size_t>> numbers;  // nothing: not determined
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    auto& number = numbers[table.names[i]];
    if (!adjusted.points[i].position_in_world) continue;
    number = points.positions.size();
    points.positions.push_back(*adjusted.points[i].position_in_world);
  }
  for (MeasuredReport::Figure& figure : report.figures) {
    std::vector<std::size_t> of;
    for (const std::string& name : figure.points) {
      const auto number = numbers.find(name);
      if (number == numbers.end())
        return fail(Errc::kBadInput, "the table of marks has no point \"" + name + "\"", {"figures"_option});
      if (number->second)
        of.push_back(*number->second);
      else
        figure.undetermined = name;
    }
    if (!figure.undetermined.empty()) continue;
    const auto measured = measure_figure(figure.kind, of, points);
    if (measured)
      figure.measured = *measured;
    else if (measured.error().code == Errc::kBadInput)
      return tl::unexpected(measured.error());
    else
      figure.refused = measured.error().message;
  }
  return {};
}

}  // namespace

Result<MeasuredReport> measure_points(const std::filesystem::path& folder, const std::filesystem::path& marks,
                                      const MeasurePointsOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  MeasuredReport report;
  COLLINEA_TRY(report.figures, read_figures(options.figures));
  COLLINEA_TRY(const Project project, open_project(folder, run));
  COLLINEA_TRY(ProjectAdjustment adjustment, adjustment_with_marks(project));
  AdjustmentTask& task = adjustment.task;
  COLLINEA_TRY(const MarkTable table, read_marks(marks, task.block, options.sigma_px));
  COLLINEA_TRY(MarkedBlock block,
               MarkedBlock::of(std::move(task.block), task.scope, task.options.adjust, BlockControl::kKept, run));
  COLLINEA_TRY(const AdjustedMarks adjusted, block.adjust(table.points));
  report.sigma0 = adjusted.sigma0;
  report.is_placed = adjusted.placed;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    MeasuredReport::Point& point = report.points.emplace_back();
    point.name = table.names[i];
    for (std::size_t m = 0; m < table.points[i].marks.size(); ++m) {
      const ImageId image = table.points[i].marks[m].image;
      point.marks.push_back(
          {block.block().images.at(image).file, is_oriented(block.block(), image), adjusted.points[i].marks[m]});
    }
  }
  std::vector<double> heights;
  COLLINEA_TRY(take_positions(block.block(), adjusted, report, heights));
  COLLINEA_TRY(measure_figures(table, adjusted, std::move(heights), report));
  return report;
}

}  // namespace collinea
