// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/surface_pieces.h"

#include <numeric>

namespace collinea {

Result<SurfacePieces> SurfacePieces::open(const DsmFiles& files) {
  COLLINEA_TRY(auto height, GeoTiffReader::open(files.height));
  COLLINEA_TRY(auto sigma, GeoTiffReader::open(files.sigma));
  COLLINEA_TRY(auto sigma_relative, GeoTiffReader::open(files.sigma_relative));
  COLLINEA_TRY(auto state, GeoTiffReader::open(files.state));
  return SurfacePieces(std::move(height), std::move(sigma), std::move(sigma_relative), std::move(state));
}

Result<SurfacePiece> SurfacePieces::read_heights(int column, int row, int width, int rows) const {
  SurfacePiece piece{column, row, {}, {}, {}};
  COLLINEA_TRY(piece.height_m, height_.read_float(column, row, width, rows));
  COLLINEA_TRY(piece.state, state_.read_byte(column, row, width, rows));
  return piece;
}

Result<> SurfacePieces::read_sigmas(SurfacePiece& piece) const {
  COLLINEA_TRY(piece.sigma_m,
               sigma_relative_.read_float(piece.column, piece.row, piece.state.width, piece.state.height));
  return {};
}

Result<FloatImage> SurfacePieces::read_added_variance(const SurfacePiece& piece) const {
  COLLINEA_TRY(FloatImage added, sigma_.read_float(piece.column, piece.row, piece.state.width, piece.state.height));
  for (std::size_t i = 0; i < added.data.size(); ++i) {
    const float sigma_m = added.data[i], relative_m = piece.sigma_m.data[i];
    added.data[i] = std::max(0.0f, sigma_m * sigma_m - relative_m * relative_m);
  }
  return added;
}

int SurfacePieces::piece_columns() const {
  const int both = std::lcm(each_, kSquare), unit = both <= kPieceColumns ? both : each_;
  return std::max(1, kPieceColumns / unit) * unit;
}

}  // namespace collinea
