// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/step_figures.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "collinea/base/words.h"
#include "collinea/quality/variance_components.h"
#include "collinea/report/internal/finding_json.h"
#include "collinea/report/json_values.h"
#include "collinea/store/packed_fields.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

// Members of records that have a row for each image, point or camera.
constexpr std::array<std::string_view, 7> kTables = {
    "control", "positions", "geodetic", "position_precision", "centre_sigma_m", "rotation_sigma_rad", "calibration"};

std::string name_of(ImageId image, const Block& block) {
  const auto found = block.images.find(image);
  return found == block.images.end() ? "image " + std::to_string(image.value) : found->second.file;
}
template <class Tag>
std::string name_of(Id<Tag> id, const Block&) {
  return std::to_string(id.value);
}

std::string name_of(const std::string& word, const Block&) { return word; }

template <class T>
json value_of(const T& value, const Block& block);

template <class T>
json list_of(const T& values, const Block& block) {
  json list = json::array();
  for (const auto& value : values) list.push_back(value_of(value, block));
  return list;
}

template <class T>
json object_of(const T& record, const Block& block) {
  json object = json::object();
  packing::for_each_member<T>([&](std::string_view name, auto member) {
    if (std::ranges::find(kTables, name) == kTables.end()) object[std::string(name)] = value_of(record.*member, block);
  });
  return object;
}

template <class T>
json value_of(const T& value, const Block& block) {
  using namespace packing;
  if constexpr (std::is_same_v<T, Finding>) {
    return finding_json(value, block);
  } else if constexpr (std::is_same_v<T, Gauge>) {
    return words_of(value);
  } else if constexpr (std::is_floating_point_v<T>) {
    return number(value);
  } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (detail::kIsWordOr<T>) {
    return value.text();
  } else if constexpr (Worded<T>) {
    return std::string(word_of(value));
  } else if constexpr (is_id<T>) {
    return name_of(value, block);
  } else if constexpr (is_optional<T>) {
    return value ? value_of(*value, block) : json(nullptr);
  } else if constexpr (is_list<T> || is_array<T>) {
    return list_of(value, block);
  } else if constexpr (FixedMatrix<T>) {
    return list_of(std::span(value.data(), std::size_t(value.size())), block);
  } else if constexpr (is_map<T>) {
    json object = json::object();
    for (const auto& [id, its] : value) object[name_of(id, block)] = value_of(its, block);
    return object;
  } else {
    return object_of(value, block);
  }
}

template <class Record>
json figures_of_record(const Record& record, const Block& block) {
  return object_of(record, block);
}

json figures_of_record(const OrientationRecord& record, const Block& block) {
  json figures = object_of(record, block);
  figures["gsd_m"] = value_of(record.gsd_m(), block);
  figures["sigma_factors"] = list_of(factors_of(record.sigma_factors), block);  // of all groups, in their order
  figures["calibration"] = word_of(record.calibration);
  return figures;
}

json figures_of_record(const AdjustmentRecord& record, const Block& block) {
  json figures = object_of(record, block);
  figures["sigma_factors"] = list_of(factors_of(record.sigma_factors), block);
  figures["calibration"] = word_of(record.calibration.parameters);
  return figures;
}

}  // namespace

json figures_of(const StepOutcome& outcome, const Block& block) {
  if (const auto why = skipped_because(outcome)) return {{"skipped_because", finding_json(*why, block)}};
  json figures = std::visit([&](const auto& record) { return figures_of_record(record, block); }, outcome);
  figures.erase("skipped_because");
  return figures;
}

}  // namespace collinea
