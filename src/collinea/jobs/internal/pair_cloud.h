// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "collinea/base/record_spool.h"
#include "collinea/cloud/ply.h"
#include "collinea/jobs/internal/pair_sigma.h"
#include "collinea/jobs/internal/pair_steps.h"
#include "collinea/jobs/internal/thinned_sample.h"
#include "collinea/surface/dsm.h"

namespace collinea {

/// What is known of a cloud without its points.
struct PairCloudSummary {
  std::size_t points = 0;
  double median_sigma_px = 0, median_sigma_z = 0;
  double pixel_m = 1;                         ///< on the ground, of the images as they are worked on
  double distance_m = 0;                      ///< that a point has to itself on the map, as the side of a square
  RecordSpool matching_sigmas;                ///< floats: of each point, without what the orientation adds [m]
  std::vector<PositionSigma> by_orientation;  ///< of heights on the map, at points of the orientation
};

/// Points of the surface on their way into cloud.ply, piece by piece: with the colours of the left image, in the frame
/// of the left camera or with absolute orientation on the ground. Sigmas are those along the view, with what relative
/// and absolute orientation add.
class PairCloud {
 public:
  /// Reads the colours. Errors: files.
  static Result<PairCloud> create(const std::filesystem::path& folder, const PairFiles& pair, const ModelOfPair& model,
                                  const std::optional<AbsoluteOrientation>& absolute,
                                  const PairOrientationSigma& by_orientation, const Run& run);

  struct Piece {
    std::vector<CloudPoint> points;
    std::vector<float> matching_sigmas_m;    ///< of the points
    std::vector<float> sigmas_px, sigmas_z;  ///< of the points before those behind the camera went
  };
  /// From several threads at once.
  [[nodiscard]] Piece piece_of(std::span<const LevelPoint> points) const;
  /// In the order of the file.
  void add(const Piece& piece);
  [[nodiscard]] Result<PairCloudSummary> finish();

 private:
  PairCloud(const ModelOfPair& model, const std::optional<AbsoluteOrientation>& absolute,
            const PairOrientationSigma& by_orientation, Raster<std::uint8_t> image, ResamplingLattice lattice,
            PlyWriter writer, RecordSpool matching_sigmas);
  [[nodiscard]] std::vector<PositionSigma> position_sigmas() const;
  [[nodiscard]] std::array<std::uint8_t, 3> colour_at(const LevelPoint& point) const;

  const ModelOfPair& model_;
  const PairOrientationSigma& by_orientation_;
  std::optional<Similarity3> ground_from_model_;
  Similarity3 map_from_model_;
  Rigid3 left_from_map_;
  Raster<std::uint8_t> image_;  // the left one, of 1 or 3 channels
  ResamplingLattice lattice_;
  PlyWriter writer_;
  RecordSpool matching_sigmas_;
  std::size_t points_ = 0;
  ThinnedSample sigmas_px_, sigmas_z_, sizes_m_, x_m_, y_m_;
};

/// From the frame of the left camera to one with z up: by absolute orientation, else half a turn about x.
[[nodiscard]] Similarity3 map_from_model(const std::optional<AbsoluteOrientation>& absolute);

}  // namespace collinea
