// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/feature_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "collinea/base/nearest_names.h"

namespace collinea {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The columns of a table, empty or NaN where it does not give them.
struct Columns {
  std::vector<std::string> feature, vertex, image, code, layer, kind;
  std::vector<double> x, y, e, n, h, sigma_px, sigma_m;
};

std::vector<std::string> words_or_none(const TextTable& table, const char* name) {
  const auto column = table.find(name);
  std::vector<std::string> words;
  for (const auto& row : table.rows) words.push_back(column && row[*column] != "-" ? row[*column] : "");
  return words;
}

Result<Columns> columns_of(const TextTable& table) {
  Columns all;
  COLLINEA_TRY(all.feature, table.words("feature"));
  for (const auto& [name, words] :
       {std::pair("vertex", &all.vertex), std::pair("image", &all.image), std::pair("code", &all.code),
        std::pair("layer", &all.layer), std::pair("kind", &all.kind)})
    *words = words_or_none(table, name);
  for (const auto& [name, unit, numbers] :
       {std::tuple("x", "px", &all.x), std::tuple("y", "px", &all.y), std::tuple("sigma", "px", &all.sigma_px),
        std::tuple("E", "m", &all.e), std::tuple("N", "m", &all.n), std::tuple("H", "m", &all.h),
        std::tuple("sigma_m", "m", &all.sigma_m)}) {
    COLLINEA_TRY(*numbers, table.numbers_or(name, unit, kNone));
  }
  return all;
}

/// Features as their rows come.
class Builder {
 public:
  Builder(const Block& block, std::span<const DrawingCode> codes, double sigma_px)
      : codes_(codes), sigma_px_(sigma_px) {
    for (const auto& [id, image] : block.images) {
      ids_[image.file] = id;
      files_.push_back(image.file);
    }
  }

  Result<> add(const Columns& of, std::size_t row) {
    const auto [known, is_new] = numbers_.try_emplace(of.feature[row], features.size());
    if (is_new) features.push_back({.id = of.feature[row]});
    if (of.feature[row] == "*")
      return fail(Errc::kBadInput, "* is no feature: its rows are known by a name of their own");
    AskedFeature& feature = features[known->second];
    if (is_new) kinds_.emplace_back();
    COLLINEA_TRY(describe(feature, kinds_[known->second], of, row));
    return of.image[row].empty() ? add_position(feature, of, row) : add_mark(feature, of, row);
  }

  void finish(const std::string& layer) {
    for (std::size_t i = 0; i < features.size(); ++i) {
      AskedFeature& feature = features[i];
      if (feature.layer.empty()) feature.layer = layer;
      feature.kind = kinds_[i].value_or(feature.vertices.size() == 1 ? VectorKind::kPoint : VectorKind::kLine);
    }
  }

  std::vector<AskedFeature> features;

 private:
  Result<> describe(AskedFeature& feature, std::optional<VectorKind>& kind, const Columns& of, std::size_t row) {
    if (!of.kind[row].empty()) {
      const auto read = from_word<VectorKind>(of.kind[row]);
      if (!read) return fail(Errc::kBadInput, "\"" + of.kind[row] + "\" is no kind: it is point, line or polygon");
      if (!kind) kind = read;
    }
    if (feature.layer.empty()) feature.layer = of.layer[row];
    if (of.code[row].empty() || !feature.code.empty()) return {};
    const auto code = std::ranges::find(codes_, of.code[row], &DrawingCode::code);
    if (code == codes_.end()) return fail(Errc::kBadInput, "the code list has no code \"" + of.code[row] + "\"");
    feature.code = code->code;
    if (feature.layer.empty()) feature.layer = code->layer;
    if (!kind) kind = code->kind;
    return {};
  }

  Result<> add_mark(AskedFeature& feature, const Columns& of, std::size_t row) {
    const auto image = ids_.find(of.image[row]);
    if (image == ids_.end())
      return tl::unexpected(with_nearest(Error{Errc::kBadInput, fmt::format("there is no image \"{}\"", of.image[row])},
                                         of.image[row], files_));
    if (!std::isfinite(of.x[row]) || !std::isfinite(of.y[row])) return fail(Errc::kBadInput, "the mark has no x, y");
    const double sigma = std::isnan(of.sigma_px[row]) ? sigma_px_ : of.sigma_px[row];
    if (!(sigma > 0)) return fail(Errc::kBadInput, "sigma is not above 0");
    const ImageMark mark{image->second, {of.x[row], of.y[row]}, sigma};
    if (!of.vertex[row].empty()) {
      const auto [known, is_new] =
          vertices_.try_emplace(std::pair(feature.id, of.vertex[row]), feature.vertices.size());
      auto* marked = is_new ? nullptr : std::get_if<MarkedVertex>(&feature.vertices[known->second]);
      if (marked) marked->marks.push_back(mark);
      if (marked) return {};
      if (!is_new) return fail(Errc::kBadInput, "vertex " + of.vertex[row] + " has coordinates already");
    }
    feature.vertices.emplace_back(MarkedVertex{{mark}});
    return {};
  }

  Result<> add_position(AskedFeature& feature, const Columns& of, std::size_t row) {
    if (!std::isfinite(of.e[row]) || !std::isfinite(of.n[row]))
      return fail(Errc::kBadInput, "it gives neither an image with x, y nor coordinates E, N");
    const double sigma = of.sigma_m[row];
    if (!std::isnan(sigma) && !(sigma > 0)) return fail(Errc::kBadInput, "sigma_m is not above 0");
    if (!of.vertex[row].empty() &&
        !vertices_.try_emplace(std::pair(feature.id, of.vertex[row]), feature.vertices.size()).second)
      return fail(Errc::kBadInput, "vertex " + of.vertex[row] + " stands there already");
    const auto known = std::isnan(sigma) ? std::nullopt : std::optional(sigma);
    if (std::isfinite(of.h[row]))
      feature.vertices.emplace_back(
          GivenVertex{{of.e[row], of.n[row], of.h[row]},
                      known ? std::optional(Eigen::Vector3d::Constant(*known).eval()) : std::nullopt});
    else
      feature.vertices.emplace_back(VertexOnSurface{{of.e[row], of.n[row]}, known});
    return {};
  }

  std::span<const DrawingCode> codes_;
  double sigma_px_;
  std::map<std::string, ImageId> ids_;
  std::vector<std::string> files_;
  std::map<std::string, std::size_t> numbers_;  // of features
  std::vector<std::optional<VectorKind>> kinds_;
  std::map<std::pair<std::string, std::string>, std::size_t> vertices_;
};

}  // namespace

Result<std::vector<AskedFeature>> features_in(const TextTable& table, const Block& block,
                                              std::span<const DrawingCode> codes, double sigma_px,
                                              const std::string& layer) {
  COLLINEA_TRY(const Columns columns, columns_of(table));
  Builder builder(block, codes, sigma_px);
  for (std::size_t row = 0; row < table.rows.size(); ++row)
    if (const auto added = builder.add(columns, row); !added)
      return tl::unexpected(Error(added.error()).within(fmt::format("row {}", row + 1)));
  if (builder.features.empty()) return fail(Errc::kBadInput, "there are no features");
  builder.finish(layer);
  return std::move(builder.features);
}

}  // namespace collinea
