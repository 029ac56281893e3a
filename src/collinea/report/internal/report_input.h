// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/block/gauge.h"
#include "collinea/report/product_words.h"
#include "collinea/report/report_options.h"
#include "collinea/report/signed_files.h"
#include "collinea/store/project_store.h"

namespace collinea {

/// A file that was made for the user.
struct ReportProduct {
  ProductFile file{};
  std::uint64_t bytes = 0;
};

/// What heights refer to.
enum class HeightReference : std::uint8_t {
  kMiddleCamera,   ///< relative: zero at the middle camera
  kControlPoints,  ///< as those of the control points
  kEllipsoid,      ///< above the WGS 84 ellipsoid, as receivers give them
};

/// Names and their values, as texts.
using NamedValues = std::vector<std::pair<std::string, std::string>>;

/// All that a report tells. Residuals of tie points are computed from `block`; images of `block` without a pose are
/// listed as not oriented. Empty lists and missing values leave their part of the report out.
struct ReportInput {
  std::string title;                         ///< of the project
  std::string date;                          ///< as it shall be printed; empty: none
  Block block;                               ///< as adjusted
  std::map<CameraId, Camera> first_cameras;  ///< before the adjustment
  std::map<CameraId, std::array<double, Camera::kAllParams>>
      camera_sigma;                                       ///< of Camera::params; 0 or NaN: fixed or unknown
  std::map<ImageId, Eigen::Vector3d> centre_sigma_m;      ///< of projection centres: east, north, up
  std::map<ImageId, Eigen::Vector3d> rotation_sigma_rad;  ///< of small rotations about the axes of the world
  std::vector<ControlDifference> control;
  std::vector<PositionDifference> positions;
  std::vector<GeodeticDifference> geodetic;
  double sigma0 = std::numeric_limits<double>::quiet_NaN();
  long redundancy = 0;
  bool georeferenced = false;                       ///< false: a local frame
  bool metric = false;                              ///< false: lengths are in units of the model, not metres
  std::string crs_name;                             ///< "WGS 84 / UTM zone 33N"
  std::optional<HeightReference> height_reference;  ///< nothing: the CRS says it
  std::optional<Gauge> gauge;                       ///< what fixes position, attitude and scale
  std::optional<double> gsd_m;                      ///< ground size of a pixel
  std::vector<Finding> skipped;                     ///< images that are not in the block: the first subjects, and why
  std::vector<Finding> findings;
  std::vector<StepRecord> steps;
  std::vector<ReportProduct> products;
  std::filesystem::path dsm, ortho;    ///< GeoTIFFs to show; empty: none
  std::filesystem::path frames;        ///< folder with those of the planes of the record of the step frames
  std::optional<NamedValues> options;  ///< those that were chosen; nothing: not known
  SpellOption spelling = {};           ///< of options on the page, as they are typed; nothing: "option name = value"
  NamedValues versions;                ///< program and libraries
  ReportOptions signer;                ///< who signs
  std::optional<SignedFiles> files;    ///< what the signature stands for; nothing: not known
};

}  // namespace collinea
