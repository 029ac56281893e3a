// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/asked_vertices.h"
#include "collinea/serve/internal/bounded_json.h"

#include <stdexcept>
#include <string>

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr std::size_t kMostPositions = 20'000;

template <int kSize>
Eigen::Matrix<double, kSize, 1> numbers_in(const json& list, const char* what) {
  if (!list.is_array() || list.size() != kSize)
    throw std::invalid_argument(std::string(what) + ": a list of " + std::to_string(kSize) + " numbers");
  Eigen::Matrix<double, kSize, 1> out;
  for (int i = 0; i < kSize; ++i) out[i] = list.at(std::size_t(i)).get<double>();
  if (!out.allFinite()) throw std::invalid_argument(std::string(what) + ": a number is not finite");
  return out;
}

double positive(double value, const char* what) {
  if (!(value > 0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(what) + ": a standard deviation is above 0");
  return value;
}

MarkedVertex marked_in(const json& marks) {
  if (!marks.is_array() || marks.empty() || marks.size() > kMostAskedMarks)
    throw std::invalid_argument("marks: a list of 1 to " + std::to_string(kMostAskedMarks));
  MarkedVertex vertex;
  for (const json& mark : marks) {
    vertex.marks.push_back({image_in(mark.at("image")), numbers_in<2>(mark.at("pixel"), "pixel"),
                            positive(mark.value("sigma_px", 0.5), "sigma_px")});
  }
  return vertex;
}

GivenVertex given_in(const json& one) {
  GivenVertex vertex{numbers_in<3>(one.at("at"), "at")};
  const auto sigma = one.find("sigma_m");
  const bool has_sigma = sigma != one.end() && !sigma->is_null();
  if (has_sigma)
    vertex.sigma_m =
        sigma->is_array() ? numbers_in<3>(*sigma, "sigma_m") : Eigen::Vector3d::Constant(sigma->get<double>()).eval();
  if (has_sigma) positive(vertex.sigma_m->minCoeff(), "sigma_m");
  const std::string source = one.value("source", has_sigma ? "cloud" : "typed");
  if (source != "cloud" && source != "typed") throw std::invalid_argument("source: it is cloud or typed");
  vertex.source = source == "cloud" ? VertexSource::kCloud : VertexSource::kTyped;
  return vertex;
}

RepeatedVertex repeated_in(const json& one, const Drawing& drawing, const Block& block) {
  const auto id = one.at("feature").get<std::string>();
  const auto number = one.at("vertex").get<std::int64_t>();
  const DrawnFeature* feature = drawing.features.find(id);
  if (!feature) throw std::out_of_range("there is no feature " + id.substr(0, 100));
  if (number < 0 || std::size_t(number) >= feature->vertices.size())
    throw std::out_of_range("feature " + id.substr(0, 100) + " has " + std::to_string(feature->vertices.size()) +
                            " vertices, counted from 0");
  return repeated_vertex(feature->vertices[std::size_t(number)], block);
}

AskedVertex vertex_in(const json& one, const Drawing& drawing, const Block& block) {
  if (!one.is_object()) throw std::invalid_argument("a vertex is an object");
  if (one.contains("marks")) return marked_in(one.at("marks"));
  if (one.contains("at")) return given_in(one);
  if (one.contains("feature")) return repeated_in(one, drawing, block);
  if (!one.contains("surface")) throw std::invalid_argument("a vertex has marks, surface, at or feature");
  VertexOnSurface vertex{numbers_in<2>(one.at("surface"), "surface")};
  if (const auto sigma = one.find("sigma_m"); sigma != one.end() && !sigma->is_null())
    vertex.sigma_m = positive(sigma->get<double>(), "sigma_m");
  return vertex;
}

}  // namespace

Result<json> asked_object(std::string_view body) {
  try {
    json asked = bounded_json(body);
    if (!asked.is_object()) return fail(Errc::kBadInput, "an object is asked for");
    return asked;
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
}

Result<std::vector<AskedVertex>> asked_vertices(const json& asked, const Drawing& drawing, const Block& block) {
  const auto list = asked.find("vertices");
  if (list == asked.end() || !list->is_array() || list->empty() || list->size() > kMostAskedVertices)
    return fail(Errc::kBadInput, "vertices: a list of 1 to " + std::to_string(kMostAskedVertices));
  std::vector<AskedVertex> vertices;
  try {
    for (const json& one : *list) vertices.push_back(vertex_in(one, drawing, block));
  } catch (const std::out_of_range& error) {
    return fail(Errc::kNotFound, error.what());
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, "vertex " + std::to_string(vertices.size()) + ": " + error.what());
  }
  return vertices;
}

Result<std::vector<Eigen::Vector2d>> asked_positions(const json& asked, const char* name, std::size_t least) {
  const auto list = asked.find(name);
  if (list == asked.end() || !list->is_array() || list->size() < least || list->size() > kMostPositions)
    return fail(Errc::kBadInput, std::string(name) + ": a list of " + std::to_string(least) + " to " +
                                     std::to_string(kMostPositions) + " positions");
  std::vector<Eigen::Vector2d> positions;
  try {
    for (const json& one : *list) positions.emplace_back(numbers_in<2>(one, name));
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
  return positions;
}

}  // namespace collinea
