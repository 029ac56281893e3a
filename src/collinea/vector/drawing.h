// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <ranges>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

inline constexpr Word<VectorKind> kVectorKindWords[] = {
    {VectorKind::kPoint, "point"}, {VectorKind::kLine, "line"}, {VectorKind::kPolygon, "polygon"}};
[[nodiscard]] constexpr std::span<const Word<VectorKind>> words(VectorKind) { return kVectorKindWords; }

/// What a drawn vertex was measured by.
enum class VertexSource : std::uint8_t { kStereo, kMono, kSurface, kCloud, kTyped };
inline constexpr Word<VertexSource> kVertexSourceWords[] = {
    {VertexSource::kStereo, "stereo", "marks in two images or more"},
    {VertexSource::kMono, "mono", "a mark in one image, and the surface"},
    {VertexSource::kSurface, "surface", "a position in plan, and the surface"},
    {VertexSource::kCloud, "cloud", "a point of the cloud"},
    {VertexSource::kTyped, "typed", "coordinates"}};
[[nodiscard]] constexpr std::span<const Word<VertexSource>> words(VertexSource) { return kVertexSourceWords; }

/// Where an image shows a vertex.
struct VertexMark {
  std::string image;  ///< its file
  Eigen::Vector2d pixel;
  double sigma_px = 0.5;

  friend bool operator==(const VertexMark&, const VertexMark&) = default;
};

struct DrawnVertex {
  Eigen::Vector3d position;                      ///< easting, northing, height [m]
  std::optional<Eigen::Matrix3d> covariance_m2;  ///< of it; nothing: not known
  VertexSource source = VertexSource::kTyped;
  std::vector<VertexMark> marks = {};  ///< that gave it

  /// Nothing: not known.
  [[nodiscard]] std::optional<Eigen::Vector3d> sigma_m() const;
  friend bool operator==(const DrawnVertex&, const DrawnVertex&) = default;
};

struct DrawnFeature {
  std::string id, layer;
  VectorKind kind = VectorKind::kLine;
  std::map<std::string, std::string> attributes = {};
  std::vector<DrawnVertex> vertices = {};  ///< a polygon is closed by itself
};

using LayerColour = std::array<std::uint8_t, 3>;  ///< red, green, blue
inline constexpr LayerColour kPlainColour = {192, 0, 0};
/// "#c00000"; nothing: it is written otherwise.
[[nodiscard]] std::optional<LayerColour> colour_in(std::string_view text);
[[nodiscard]] std::string text_of(const LayerColour& colour);

struct DrawingLayer {
  std::string name;
  std::optional<VectorKind> kind = {};  ///< of what is drawn on it; nothing: anything
  LayerColour colour = kPlainColour;
};

/// A line of a code list: what is drawn on which layer, and what that means.
struct DrawingCode {
  std::string code, layer;
  VectorKind kind = VectorKind::kLine;
  LayerColour colour = kPlainColour;
  std::string meaning;
};

/// Features in the order in which they were first drawn, each found by its id at once however many there are.
class DrawnFeatures {
 public:
  DrawnFeatures() = default;
  DrawnFeatures(std::initializer_list<DrawnFeature> features);

  [[nodiscard]] auto begin() const { return std::views::values(by_order_).begin(); }
  [[nodiscard]] auto end() const { return std::views::values(by_order_).end(); }
  [[nodiscard]] std::size_t size() const { return by_order_.size(); }
  [[nodiscard]] bool empty() const { return by_order_.empty(); }
  [[nodiscard]] const DrawnFeature* find(const std::string& id) const;
  /// Its id must stay as it is.
  [[nodiscard]] DrawnFeature* find(const std::string& id);
  /// Behind all others; there must be none of its id.
  void add(DrawnFeature feature);
  /// False: there is none.
  bool erase(const std::string& id);

 private:
  std::map<std::uint64_t, DrawnFeature> by_order_;
  std::unordered_map<std::string, std::uint64_t> order_of_;
};

/// Everything that is drawn in a project.
struct Drawing {
  std::vector<DrawingLayer> layers = {};  ///< by the order in which they were named
  DrawnFeatures features = {};
  std::set<std::string> erased = {};  ///< ids of features that are no more
};

/// The layers of a drawing, of a code list, and of features on layers that neither names.
[[nodiscard]] std::vector<DrawingLayer> layers_of(const Drawing& drawing, std::span<const DrawingCode> codes);

/// The drawing as tables: of each layer and kind of feature one ("roof_line"; fields feature, layer, code, source, the
/// largest sigma of a vertex on each axis, and each attribute), and "vertices" with every vertex, its sigmas and its
/// covariances. Fields and tables whose names are taken get a
/// number behind them, tables whose names a GeoPackage keeps for itself "layer_" before them.
[[nodiscard]] std::vector<VectorLayer> vector_layers(const Drawing& drawing, std::span<const DrawingCode> codes);

/// The features alone, on layers with the names that they have: for drawings (write_dxf()).
[[nodiscard]] std::vector<VectorLayer> plain_layers(const Drawing& drawing, std::span<const DrawingCode> codes);

}  // namespace collinea
