// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_positions.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>

#include "collinea/block/image_axes.h"
#include "collinea/block/world_frame.h"
#include "collinea/geodesy/heights.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/import/image_names.h"
#include "collinea/io/opk.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

// The digits in front of the extension.
std::optional<int> last_number(const std::string& file) {
  const std::string stem = std::filesystem::path(file).stem().string();
  const auto before = stem.find_last_not_of("0123456789");
  const auto value = integer(before == std::string::npos ? stem : stem.substr(before + 1));
  return value && *value >= 0 && *value < 1'000'000'000 ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

/// Images by their number; of several with one number those in the folder that the file is of.
std::map<int, ImageId> images_by_number(const Block& block, const std::filesystem::path& path,
                                        std::set<int>& ambiguous) {
  const std::string name = path.stem().string();
  std::map<int, std::vector<ImageId>> all;
  for (const auto& [id, image] : block.images)
    if (const auto number = last_number(image.file)) all[*number].push_back(id);
  std::map<int, ImageId> found;
  for (const auto& [number, images] : all) {
    std::vector<ImageId> here;
    for (const ImageId id : images) {
      const std::string folder = std::filesystem::path(block.images.at(id).file).parent_path().filename().string();
      if (!folder.empty() && name.starts_with(folder)) here.push_back(id);
    }
    if (images.size() == 1) here = images;
    if (here.size() == 1)
      found[number] = here[0];
    else
      ambiguous.insert(number);
  }
  return found;
}

class PositionImporter {
 public:
  PositionImporter(Imported& imported, const ImportOptions& options)
      : imported_(imported), block_(imported.block), options_(options) {}

  Result<std::set<ImageId>> add(const PositionFile& file, const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    std::set<int> ambiguous;
    const std::map<int, ImageId> by_number = images_by_number(block_, path, ambiguous);
    const ImageNames names(block_);
    std::size_t missing = 0, timed = 0;
    std::string first_missing;
    std::set<ImageId> found;
    for (const PositionFileRow& row : file.rows) {
      std::optional<ImageId> id;
      if (row.number < 0) {
        id = names.find(row.image);
      } else if (const auto its = by_number.find(row.number); its != by_number.end()) {
        id = its->second;
      }
      if (!id) {
        if (missing++ == 0) first_missing = row.number < 0 ? row.image : std::to_string(row.number);
        continue;
      }
      if (!found.insert(*id).second)
        return fail(Errc::kBadInput, fmt::format("{}: line {}: {} is there twice, by different names", path.string(),
                                                 row.line, block_.images.at(*id).file));
      if (Result<> taken = take(row, file.crs, *id); !taken)
        return tl::unexpected(Error(taken.error()).within(fmt::format("{}: line {}", path.string(), row.line)));
      timed += !row.taken.empty();
    }
    if (found.empty())
      return fail(Errc::kBadInput, fmt::format("{}: none of its {} images is among the photographs; the first is {}",
                                               path.string(), file.rows.size(), first_missing));
    if (missing > 0)
      say(ambiguous.empty() ? FindingCode::kPositionsOfOthers : FindingCode::kPositionsAmbiguous,
          {Subject::file(name), Subject::file(first_missing)}, missing, file.rows.size());
    if (found.size() < block_.images.size())
      say(FindingCode::kPositionsNotStated, {Subject::file(name)}, block_.images.size() - found.size(),
          block_.images.size());
    // Clocks of cameras and of GPS differ: one of them for all.
    if (timed == found.size() && found.size() == block_.images.size())
      for (const auto& [id, taken] : times_) block_.images.at(id).taken = taken;
    else if (timed > 0)
      imported_.findings.push_back(finding_of(FindingCode::kTimesOfHeaders, {Subject::file(name)}));
    return std::move(located_);
  }

 private:
  void say(FindingCode code, std::vector<Subject> subjects, std::size_t count, std::size_t of) {
    imported_.findings.push_back(
        finding_of(code, std::move(subjects), {{FigureName::kCount, double(count)}, {FigureName::kOf, double(of)}}));
    if (code == FindingCode::kPositionsAmbiguous)
      imported_.findings.back().remedies = {RemedyCode::kFolderOfEachFlight};
  }

  Result<> take(const PositionFileRow& row, const std::string& crs, ImageId id) {
    Image& image = block_.images.at(id);
    if (row.geographic || row.in_map) {
      COLLINEA_TRY(const Eigen::Vector3d geographic, geographic_of(row, crs));
      const Eigen::Vector3d default_sigma(options_.gps_sigma_m, options_.gps_sigma_m, options_.gps_sigma_height_m);
      PositionPrior prior{};
      prior.position_in_world.setZero();  // known once the world frame is
      const bool has_height = std::isfinite(geographic.z());
      prior.latitude_deg = geographic.x();
      prior.longitude_deg = geographic.y();
      prior.height_m = has_height ? geographic.z() : 0;
      prior.sigma_m = row.sigma_m.array().isNaN().select(default_sigma, row.sigma_m);
      if (!has_height) prior.sigma_m.z() = std::numeric_limits<double>::infinity();
      if (image.position) prior.height_above_start_m = image.position->height_above_start_m;
      image.position = prior;
      located_.insert(id);
    }
    if (row.attitude) {
      image.attitude = row.attitude;
      image.attitude->sigma_deg = row.sigma_deg.array().isNaN().select(0, row.sigma_deg);
    }
    if (row.angles && !image.position)
      return fail(Errc::kBadInput, "omega, phi and kappa refer to the map at a position, and this image has none");
    if (!row.taken.empty()) times_.emplace_back(id, row.taken);
    return {};
  }

  // The height of a position without one is NaN.
  Result<Eigen::Vector3d> geographic_of(const PositionFileRow& row, const std::string& file_crs) {
    if (row.geographic) return *row.geographic;
    std::string crs = file_crs.empty() ? options_.crs.value_or("") : file_crs;
    if (crs.empty())
      return fail(
          Errc::kBadInput,
          "eastings and northings of which map? Write \"# collinea positions, EPSG:code\" in the first line, or "
          "give a CRS",
          {"crs"_option});
    Eigen::Vector3d in_map = *row.in_map;
    const bool has_height = std::isfinite(in_map.z());
    if (!has_height) in_map.z() = 0;
    if (!frame_) {
      COLLINEA_TRY(const bool says, states_heights(crs));
      if (options_.heights && !says) {
        COLLINEA_TRY(crs, with_heights(crs, *options_.heights));
      }
      COLLINEA_TRY(const Eigen::Vector3d origin, geographic_from_map(crs, in_map));
      COLLINEA_TRY(frame_, LocalFrame::create(crs, origin.x(), origin.y(), origin.z()));
    }
    Eigen::Vector3d geographic = frame_->geographic_from_local(frame_->local_from_map(in_map));
    if (!geographic.allFinite()) return fail(Errc::kBadInput, "this position is outside of " + crs);
    if (!has_height) geographic.z() = std::nan("");
    return geographic;
  }

  Imported& imported_;
  Block& block_;
  const ImportOptions& options_;
  std::optional<LocalFrame> frame_;
  std::set<ImageId> located_;
  std::vector<std::pair<ImageId, std::string>> times_;
};

}  // namespace

Result<std::set<ImageId>> add_positions(Imported& imported, const PositionFile& file, const std::filesystem::path& path,
                                        const ImportOptions& options) {
  return PositionImporter(imported, options).add(file, path);
}

Result<> add_map_attitudes(Imported& imported, const PositionFile& file) {
  Block& block = imported.block;
  COLLINEA_TRY(const auto frame, world_frame(block));
  if (!frame) return {};
  const ImageNames names(block);
  std::vector<ExteriorOrientation> rows;
  std::map<ImageId, const PositionFileRow*> row_of;
  for (const PositionFileRow& row : file.rows) {
    const auto id = row.angles ? names.find(row.image) : std::nullopt;
    if (!id) continue;
    const Image& image = block.images.at(*id);
    rows.push_back({image.file, frame->map_from_local(image.position->position_in_world), *row.angles});
    row_of[*id] = &row;
  }
  COLLINEA_TRY(const auto poses, poses_of(rows, block));
  for (const auto& [id, pose] : poses) {
    AttitudePrior prior = attitude_prior(pose.rotation);
    const Eigen::Vector3d& sigma = row_of.at(id)->sigma_deg;
    prior.sigma_deg = sigma.array().isNaN().select(0, sigma);
    block.images.at(id).attitude = prior;
  }
  return {};
}

}  // namespace collinea
