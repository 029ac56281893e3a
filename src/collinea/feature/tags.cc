// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/tags.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "collinea/feature/edges.h"
#include "collinea/feature/internal/dark_quads.h"
#include "collinea/feature/internal/grey_fit.h"
#include "collinea/feature/internal/tag_model.h"

namespace collinea {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kLargestMisfit = 0.05;     // share of the variance that neither model nor noise explains
constexpr double kChance = 1e-3;            // of random cells to be read as a code, where the family is not known
constexpr double kGround_cells = 0.6;       // of the light ground about a tag that are looked at
constexpr double kDirectSide_px = 200;      // beyond it the image is reduced
constexpr double kEdgeReach_px = 4;         // about an edge of cells; what is farther away tells little of positions
constexpr double kBlurs_px[] = {0.7, 1.3};  // that are tried to read a code
constexpr double kSamplesACell = 4;         // along each axis, to read a code

// --- codes

// Pixels of a tag, and of the ground about it.
struct Bounds {
  int x0, y0, x1, y1;  // x1, y1: the last ones
};
std::optional<Bounds> bounds_of(const FloatImage& image, const TagUnknowns& u, double reach) {
  Vector2d low = Vector2d::Constant(1e30), high = -low;
  for (const double x : {-reach, reach})
    for (const double y : {-reach, reach}) {
      const Vector2d p = tag_position(u, {x, y});
      if (!p.allFinite()) return std::nullopt;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  const bool is_inside = low.minCoeff() >= 0 && high.x() <= image.width && high.y() <= image.height;
  if (!is_inside) return std::nullopt;
  return Bounds{int(low.x()), int(low.y()), std::min(int(high.x()), image.width - 1),
                std::min(int(high.y()), image.height - 1)};
}

// Greys of all cells with the ring of ground, (side + 2)^2 row by row, by least squares, as if nothing were blurred.
// Nothing: not inside the image.
std::optional<VectorXd> cell_greys(const FloatImage& image, const TagUnknowns& u, int side) {
  const double reach = 0.5 + kGround_cells / side;
  const auto bounds = bounds_of(image, u, reach);
  if (!bounds) return std::nullopt;
  const int wide = side + 2, n = wide * wide;
  const double cell_px =
      std::sqrt(std::abs(u[kTagShape] * u[kTagShape + 3] - u[kTagShape + 1] * u[kTagShape + 2])) / side;
  const int step = std::max(1, int(cell_px / kSamplesACell));
  MatrixXd normals = 1e-3 * MatrixXd::Identity(n, n);
  VectorXd right = VectorXd::Zero(n);
  double sum = 0;
  int count = 0;
  for (int y = bounds->y0; y <= bounds->y1; y += step)
    for (int x = bounds->x0; x <= bounds->x1; x += step) {
      const Vector2d p(x + 0.5, y + 0.5);
      const OnTag on = on_tag(u, p);
      if (!on.is_in_front || on.q.cwiseAbs().maxCoeff() > reach) continue;
      const Vector2d sigma = blur_in_cells(u, p, side), s = side * (on.q + Vector2d::Constant(0.5));
      const CellShares a = cell_shares(s.x(), sigma.x(), side), b = cell_shares(s.y(), sigma.y(), side);
      std::array<std::pair<int, double>, 256> parts;
      std::size_t many = 0;
      for (int j = 0; j < b.count; ++j)
        for (int i = 0; i < a.count; ++i) {
          const double share = a.share[std::size_t(i)] * b.share[std::size_t(j)];
          if (share > 0.01) parts[many++] = {(b.first + j + 1) * wide + a.first + i + 1, share};
        }
      const double grey = image.at(x, y);
      sum += grey;
      ++count;
      for (std::size_t i = 0; i < many; ++i) {
        right[parts[i].first] += parts[i].second * grey;
        for (std::size_t j = 0; j < many; ++j)
          normals(parts[i].first, parts[j].first) += parts[i].second * parts[j].second;
      }
    }
  if (count < n / 2) return std::nullopt;
  // Cells that no pixel shows, and what blur hides, are drawn towards the mean.
  const double mean = sum / count, weight = 0.02;
  normals.diagonal().array() += weight;
  right.array() += (weight + 1e-3) * mean;
  return normals.ldlt().solve(right);
}

// A plane through greys of cells that are dark or light.
struct GreyPlane {
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
  [[nodiscard]] double at(int column, int row) const { return parameters.dot(Eigen::Vector3d(1, column, row)); }
};
GreyPlane plane_through(const VectorXd& greys, int wide, int ring) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (int y = ring; y < wide - ring; ++y)
    for (int x = ring; x < wide - ring; ++x) {
      if (x != ring && y != ring && x != wide - 1 - ring && y != wide - 1 - ring) continue;
      const Eigen::Vector3d row(1, x, y);
      normals += row * row.transpose();
      right += greys[y * wide + x] * row;
    }
  return {normals.ldlt().solve(right)};
}

// The code of a tag whose border is dark and whose ground is light.
std::optional<TagBits> bits_of(const VectorXd& greys, int side, double least_contrast) {
  const int wide = side + 2;
  const GreyPlane light = plane_through(greys, wide, 0), dark = plane_through(greys, wide, 1);
  const auto is_light = [&](int x, int y) { return greys[y * wide + x] > (light.at(x, y) + dark.at(x, y)) / 2; };
  TagBits bits = 0;
  int wrong = 0;
  for (int y = 0; y < wide; ++y)
    for (int x = 0; x < wide; ++x) {
      const int ring = std::min({x, y, wide - 1 - x, wide - 1 - y});
      if (light.at(x, y) - dark.at(x, y) < least_contrast / 2) return std::nullopt;
      if (ring > 1)
        bits = bits << 1 | TagBits(is_light(x, y));
      else
        wrong += is_light(x, y) == (ring == 1);
    }
  return wrong <= side / 2 ? std::optional(bits) : std::nullopt;
}

// --- fit

TagCells cells_of(TagFamily family, int id) {
  const TagCodes& codes = tag_codes(family);
  TagCells out{codes.side + 2, {}};
  const int wide = out.side + 2;
  for (int y = 0; y < wide; ++y)
    for (int x = 0; x < wide; ++x) {
      const int ring = std::min({x, y, wide - 1 - x, wide - 1 - y});
      const int at = codes.side * codes.side - 1 - ((y - 2) * codes.side + x - 2);
      const bool is_light = ring == 0 || (ring > 1 && (codes.bits[std::size_t(id)] >> at & 1));
      out.light.push_back(is_light ? 1 : 0);
    }
  return out;
}

// Whether a pixel shows something of cells that are not what their code says.
bool shows_wrong(const TagUnknowns& u, const Vector2d& p, const Vector2d& q, int side, TagBits wrong) {
  if (wrong == 0) return false;
  const int n = side - 2;
  const Vector2d cell = side * (q + Vector2d::Constant(0.5)) - Vector2d::Ones(), reach = 2 * blur_in_cells(u, p, side);
  for (int at = 0; at < n * n; ++at) {
    if (!(wrong >> (n * n - 1 - at) & 1)) continue;
    const Vector2d away = (cell - Vector2d(at % n + 0.5, at / n + 0.5)).cwiseAbs() - Vector2d::Constant(0.5);
    if (away.x() < reach.x() && away.y() < reach.y()) return true;
  }
  return false;
}

// The pixels from which a tag is measured: all near edges, of the others one in nine,
// and none of cells that were corrected.
std::optional<GreyWindow> window_of(const FloatImage& image, const TagUnknowns& u, const TagCells& cells,
                                    TagBits wrong) {
  const double reach = 0.5 + kGround_cells / cells.side;
  const auto bounds = bounds_of(image, u, reach);
  if (!bounds) return std::nullopt;
  GreyWindow window{bounds->x0, bounds->y0, bounds->x1 - bounds->x0 + 1, bounds->y1 - bounds->y0 + 1};
  window.used.assign(std::size_t(window.count()), false);
  TagUnknowns wide = u;
  wide[kTagBlur] = kEdgeReach_px / 5;
  wide[kTagContrast] = 1;
  const TagModel model(cells, wide);
  std::array<double, TagModel::kMostUnknowns> d;
  for (int i = 0; i < window.count(); ++i) {
    const Vector2d p = window.pixel(i);
    const OnTag on = on_tag(u, p);
    if (!on.is_in_front || on.q.cwiseAbs().maxCoeff() > reach || shows_wrong(u, p, on.q, cells.side, wrong)) continue;
    const bool is_one_in_nine = i % window.width % 3 == 0 && i / window.width % 3 == 0;
    if (!is_one_in_nine) (void)model.grey(wide, p, d.data());
    window.used[std::size_t(i)] = is_one_in_nine || d[kTagBlur] != 0;
  }
  return window;
}

double squares_in(const FloatImage& image, const GreyWindow& window) {
  double n = 0, sum = 0, squares = 0;
  for (int i = 0; i < window.count(); ++i) {
    if (!window.uses(i)) continue;
    const double grey = window.grey(image, i);
    n += 1, sum += grey, squares += grey * grey;
  }
  return squares - sum * sum / n;
}

// Ground and contrast for a shape that is known.
void set_greys(const FloatImage& image, const GreyWindow& window, const TagCells& cells, TagUnknowns& u) {
  u[kTagContrast] = 1;
  const TagModel model(cells, u);
  double n = 0, s = 0, ss = 0, g = 0, sg = 0;
  for (int i = 0; i < window.count(); ++i) {
    if (!window.uses(i)) continue;
    const double light = model.grey(u, window.pixel(i), nullptr), grey = window.grey(image, i);
    n += 1, s += light, ss += light * light, g += grey, sg += light * grey;
  }
  const double determinant = n * ss - s * s;
  u[kTagContrast] = determinant > 0 ? (n * sg - s * g) / determinant : 0;
  u[kTagGround] = (g - u[kTagContrast] * s) / n;
}

/// What tags are looked for.
struct Wanted {
  std::vector<TagFamily> families;
  double chance = 1;  ///< of random cells to be read as a code, at most, where cells are corrected
  double least_contrast = 0, noise_grey = 0;

  [[nodiscard]] int most_wrong(TagFamily family) const {
    const TagCodes& codes = tag_codes(family);
    int most = 0;
    while (most < codes.correctable() && codes.chance_of_random(most + 1) <= chance) ++most;
    return most;
  }
};

// Nothing: the fit fails, or does not describe the grey values.
std::optional<Tag> measured(const FloatImage& image, const TagCorners& corners, TagFamily family,
                            const TagReading& reading, double noise_grey) {
  const TagCells cells = cells_of(family, reading.id);
  TagUnknowns start = tag_unknowns(corners);
  const auto window = window_of(image, start, cells, reading.wrong);
  if (!window) return std::nullopt;
  set_greys(image, *window, cells, start);
  const auto fit = fit_grey(image, *window, TagModel(cells, start), start, [](const VectorXd&) { return 0; });
  if (!fit) return std::nullopt;
  Tag out{.family = family,
          .id = reading.id,
          .wrong = std::popcount(reading.wrong),
          .at = fit->unknowns.head<2>(),
          .covariance = fit->cofactors.topLeftCorner<2, 2>()};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d q(i == 1 || i == 2 ? 0.5 : -0.5, i > 1 ? 0.5 : -0.5);
    Eigen::Matrix<double, 2, 13> by_unknowns;
    out.corners[i] = tag_position(fit->unknowns, q, &by_unknowns);
    out.corner_covariances[i] = by_unknowns * fit->cofactors * by_unknowns.transpose();
  }
  out.blur_px = fit->unknowns[kTagBlur];
  out.contrast = fit->unknowns[kTagContrast];
  out.sigma_grey = fit->sigma_grey;
  out.has_correlated_residuals = fit->has_correlated_residuals;
  const double variance = squares_in(image, *window) / window->count_used();
  const double misfit = (fit->sigma_grey * fit->sigma_grey - noise_grey * noise_grey) / variance;
  return misfit <= kLargestMisfit ? std::optional(out) : std::nullopt;
}

// --- large tags

// Means of k x k pixels about a quadrilateral, and where the first of them lies.
struct Reduced {
  FloatImage image;
  Vector2d origin;
};
Reduced reduced_about(const FloatImage& image, const Quad& quad, int k) {
  Vector2d low = quad[0], high = quad[0];
  for (const Vector2d& p : quad) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector2d margin = 0.5 * (high - low) + Vector2d::Constant(8.0 * k);  // of the ground about the tag
  const int x0 = std::max(0, int(low.x() - margin.x())), y0 = std::max(0, int(low.y() - margin.y()));
  const int x1 = std::min(image.width, int(high.x() + margin.x())),
            y1 = std::min(image.height, int(high.y() + margin.y()));
  Reduced out{FloatImage((x1 - x0) / k, (y1 - y0) / k), Vector2d(x0, y0)};
  for (int y = 0; y < out.image.height; ++y)
    for (int x = 0; x < out.image.width; ++x) {
      float sum = 0;
      for (int v = 0; v < k; ++v)
        for (int u = 0; u < k; ++u) sum += image.at(x0 + x * k + u, y0 + y * k + v);
      out.image.at(x, y) = sum / float(k * k);
    }
  return out;
}

// --- all of it

double longest_side(const Quad& quad) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i) longest = std::max(longest, (quad[(i + 1) % 4] - quad[i]).norm());
  return longest;
}

struct NamedReading {
  TagFamily family;
  TagReading reading;
};

// What the families make of a quadrilateral, those with the fewest wrong cells first.
std::vector<NamedReading> readings_of(const FloatImage& image, const TagUnknowns& shape, const Wanted& wanted) {
  std::vector<NamedReading> out;
  for (const int side : {4, 5, 6}) {
    std::optional<std::optional<TagBits>> bits;  // of this many cells, once they are needed
    for (const TagFamily family : wanted.families) {
      if (tag_codes(family).side != side) continue;
      if (!bits) {
        const auto greys = cell_greys(image, shape, side + 2);
        bits = greys ? bits_of(*greys, side + 2, wanted.least_contrast) : std::nullopt;
      }
      const auto reading = *bits ? read_tag(family, **bits, wanted.most_wrong(family)) : std::nullopt;
      if (reading) out.push_back({family, *reading});
    }
  }
  std::ranges::stable_sort(out, {}, [](const NamedReading& one) { return std::popcount(one.reading.wrong); });
  return out;
}

// Whether the border is dark and the ground light all the way round: most quadrilaterals of photographs are of one tone
// on some of their sides alone.
bool has_border(const FloatImage& image, const Quad& quad) {
  constexpr std::size_t kSteps = 6;
  constexpr int kExceptions = 2;
  constexpr double kInside = 0.07;  // of a side; within the border of all families
  const TagUnknowns shape = tag_unknowns(quad);
  std::array<double, 4 * kSteps> border{}, ground{};
  for (std::size_t i = 0; i < border.size(); ++i) {
    const double along = (double(i % kSteps) + 0.5) / kSteps - 0.5;
    const auto grey_at = [&](double away) {
      const std::array<Vector2d, 4> q{{{along, -away}, {along, away}, {-away, along}, {away, along}}};
      const Vector2d p = tag_position(shape, q[i / kSteps]);
      return double(bilinear(image, p.x(), p.y()));
    };
    border[i] = grey_at(0.5 - kInside);
    ground[i] = grey_at(0.5 + kInside);
  }
  const auto mean = [](const auto& greys) {
    return std::accumulate(greys.begin(), greys.end(), 0.0) / double(greys.size());
  };
  const double middle = (mean(border) + mean(ground)) / 2;
  return std::ranges::count_if(border, [&](double grey) { return grey >= middle; }) <= kExceptions &&
         std::ranges::count_if(ground, [&](double grey) { return grey <= middle; }) <= kExceptions;
}

std::optional<Tag> tag_in(const FloatImage& image, const Quad& quad, const Wanted& wanted) {
  std::optional<Tag> best;
  if (!tag_unknowns(quad).allFinite() || !has_border(image, quad)) return best;
  for (const double blur : kBlurs_px) {
    TagUnknowns shape = tag_unknowns(quad);
    shape[kTagBlur] = blur;
    for (const NamedReading& one : readings_of(image, shape, wanted)) {
      TagCorners corners;
      for (std::size_t i = 0; i < 4; ++i) corners[i] = quad[(i + std::size_t(one.reading.turns)) % 4];
      auto tag = measured(image, corners, one.family, one.reading, wanted.noise_grey);
      if (tag && (!best || tag->sigma_grey < best->sigma_grey)) best = std::move(tag);
    }
    if (best) break;
  }
  return best;
}

std::optional<Tag> tag_of_any_size(const FloatImage& image, const Quad& quad, Wanted wanted) {
  const int k = int(std::ceil(longest_side(quad) / kDirectSide_px));
  if (k <= 1) return tag_in(image, quad, wanted);
  const Reduced reduced = reduced_about(image, quad, k);
  Quad small;
  for (std::size_t i = 0; i < 4; ++i) small[i] = (quad[i] - reduced.origin) / k;
  wanted.noise_grey /= k;
  auto tag = tag_in(reduced.image, small, wanted);
  if (!tag) return tag;
  tag->at = reduced.origin + k * tag->at;
  tag->covariance *= k * k;
  for (std::size_t i = 0; i < 4; ++i) {
    tag->corners[i] = reduced.origin + k * tag->corners[i];
    tag->corner_covariances[i] *= k * k;
  }
  tag->blur_px *= k;
  return tag;
}

}  // namespace

double Tag::sigma_px() const {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1]);
}

double Tag::least_side_px() const {
  double least = 1e300;
  for (std::size_t i = 0; i < 4; ++i) least = std::min(least, (corners[(i + 1) % 4] - corners[i]).norm());
  return least;
}

std::vector<Tag> find_tags(const FloatImage& image, const TagOptions& options) {
  Wanted wanted{.least_contrast = options.least_contrast, .noise_grey = noise_of(image)};
  if (options.family) {
    wanted.families = {*options.family};
  } else {
    wanted.families.assign(std::begin(kWidestTagFamilies), std::end(kWidestTagFamilies));
    wanted.chance = kChance;
  }
  std::vector<Tag> out;
  for (const Quad& quad : dark_quads(image, options.least_contrast, options.least_side_px)) {
    auto tag = tag_of_any_size(image, quad, wanted);
    if (!tag) continue;
    const auto same = std::ranges::find_if(
        out, [&](const Tag& other) { return (other.at - tag->at).norm() < 0.5 * tag->least_side_px(); });
    if (same == out.end())
      out.push_back(std::move(*tag));
    else if (tag->sigma_grey < same->sigma_grey)
      *same = std::move(*tag);
  }
  std::ranges::stable_sort(out, {}, [](const Tag& tag) { return std::pair(tag.family, tag.id); });
  return out;
}

}  // namespace collinea
