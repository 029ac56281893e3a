// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace collinea {

/// Cells of a tag with its border and the light ground about it: (side + 2) x (side + 2), row by row; 1 is light. The
/// outermost ring stands for all that is farther out.
struct TagCells {
  int side = 0;  ///< cells of the dark square, border included
  std::vector<double> light;
  [[nodiscard]] double at(int column, int row) const {  ///< of the dark square; -1 and `side` are the ground
    return light[std::size_t(row + 1) * std::size_t(side + 2) + std::size_t(column + 1)];
  }
};

/// The unknowns of a tag in an image:
///
///     x, y, blur, ground, slope x, slope y, contrast, A11, A12, A21, A22, g1, g2
///
/// A position q of the tag (its dark square is -0.5 .. 0.5) lies in the image at p = c + A q / (1 + g' q), c = (x, y)
/// the image of its centre: where the diagonals cross. The grey value is ground + slope . (p - c) + contrast * light,
/// the cells being blurred by a Gaussian of `blur` px.
using TagUnknowns = Eigen::Matrix<double, 13, 1>;
inline constexpr int kTagBlur = 2, kTagGround = 3, kTagSlope = 4, kTagContrast = 6, kTagShape = 7;

using TagCorners = std::array<Eigen::Vector2d, 4>;  ///< upper left, and on clockwise, as the tag is printed

/// The unknowns of corners, without greys: blur 0.7 px, contrast 0.
[[nodiscard]] TagUnknowns tag_unknowns(const TagCorners& corners);

/// A position of the tag in the image, and its derivatives after the unknowns.
[[nodiscard]] Eigen::Vector2d tag_position(const Eigen::VectorXd& unknowns, const Eigen::Vector2d& q,
                                           Eigen::Matrix<double, 2, 13>* derivatives = nullptr);
/// Where on the tag a pixel lies. `is_in_front`: of the tag's horizon.
struct OnTag {
  Eigen::Vector2d q;
  bool is_in_front = false;
};
[[nodiscard]] OnTag on_tag(const Eigen::VectorXd& unknowns, const Eigen::Vector2d& p);

/// How much of a pixel's grey value comes from each cell along one axis, after blurring.
struct CellShares {
  int first = 0, count = 0;  ///< cells, -1 .. side
  std::array<double, 16> share{}, by_position{}, by_log_sigma{};
};
/// At `s` cells from the edge, blurred by sigma cells; `side` as TagCells::side. Those beyond five sigmas are left out.
[[nodiscard]] CellShares cell_shares(double s, double sigma, int side);

/// The blur along the axes of the tag [cells] at a pixel.
[[nodiscard]] Eigen::Vector2d blur_in_cells(const Eigen::VectorXd& unknowns, const Eigen::Vector2d& p, int side);

/// A tag of known cells, for fit_grey().
class TagModel {
 public:
  static constexpr std::size_t kMostUnknowns = 13;
  TagModel(const TagCells& cells, const TagUnknowns& start) : cells_(cells), start_(start) {}
  [[nodiscard]] bool is_possible(const Eigen::VectorXd& unknowns) const;
  [[nodiscard]] auto at(const Eigen::VectorXd& unknowns) const {
    return [this, &unknowns](const Eigen::Vector2d& p, double* derivatives) { return grey(unknowns, p, derivatives); };
  }
  [[nodiscard]] double grey(const Eigen::VectorXd& unknowns, const Eigen::Vector2d& p, double* derivatives) const;

 private:
  const TagCells& cells_;
  TagUnknowns start_;
};

}  // namespace collinea
