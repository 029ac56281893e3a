// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/set_attribute.h"

#include <algorithm>

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/words_in.h"

namespace collinea {

Result<> check_attribute(const std::string& name, const std::string& value) {
  COLLINEA_TRY(check_new_name(name, "NAME"));
  if (value.size() > SetAttribute::kLongestValue) return fail(Errc::kBadInput, "VALUE: it has more than 2000 bytes");
  // As a name, but that it may be long, or nothing.
  for (std::size_t i = 0; i < value.size();) {
    std::size_t end = std::min(value.size(), i + 250);
    while (end < value.size() && (static_cast<unsigned char>(value[end]) & 0xc0) == 0x80) ++end;  // between characters
    COLLINEA_TRY(check_name(value.substr(i, end - i), "VALUE"));
    i = end;
  }
  return {};
}

Result<> set_attributes(const std::map<std::string, std::string>& some, std::map<std::string, std::string>& all) {
  std::map<std::string, std::string> now = all;
  for (const auto& [name, value] : some)
    if (value == "-")
      now.erase(name);
    else
      now[name] = value;
  if (now.size() > SetAttribute::kMost)
    return fail(Errc::kBadInput, "a feature has at most " + std::to_string(SetAttribute::kMost) + " attributes");
  all = std::move(now);
  return {};
}

Result<SetAttribute> SetAttribute::parse(std::span<const std::string> words) {
  if (words.size() != 3) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "FEATURE"));
  COLLINEA_TRY(check_attribute(words[1], words[2]));
  return SetAttribute{words[0], words[1], words[2]};
}

std::vector<std::string> SetAttribute::words() const { return {feature, name, value}; }

Result<SetAttribute> SetAttribute::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> SetAttribute::apply(const EditContext&, EditedWork& work) const {
  DrawnFeature* known = work.drawing.features.find(feature);
  if (!known) return fail(Errc::kNotFound, "there is no feature " + feature);
  return set_attributes({{name, value}}, known->attributes);
}

std::vector<std::vector<std::string>> SetAttribute::restoring(const EditContext&, const EditedWork& before) const {
  const DrawnFeature* known = before.drawing.features.find(feature);
  if (!known) return {};
  const auto was = known->attributes.find(name);
  return {{std::string(kWord), feature, name, was == known->attributes.end() ? "-" : was->second}};
}

Result<SetLayer> SetLayer::parse(std::span<const std::string> words) {
  if (words.size() != 3) return wrong_form(kForm);
  SetLayer one{{.name = words[0]}};
  COLLINEA_TRY(check_new_name(one.layer.name, "LAYER"));
  one.layer.kind = from_word<VectorKind>(words[1]);
  if (!one.layer.kind && words[1] != "any")
    return fail(Errc::kBadInput, "\"" + words[1].substr(0, 40) + "\" is no kind: it is point, line, polygon or any");
  const auto colour = colour_in(words[2]);
  if (!colour) return fail(Errc::kBadInput, "\"" + words[2].substr(0, 40) + "\" is no colour such as #c00000");
  one.layer.colour = *colour;
  return one;
}

std::vector<std::string> SetLayer::words() const {
  return {layer.name, layer.kind ? std::string(word_of(*layer.kind)) : "any", text_of(layer.colour)};
}

Result<SetLayer> SetLayer::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> SetLayer::apply(const EditContext&, EditedWork& work) const {
  for (const DrawnFeature& one : work.drawing.features)
    if (layer.kind && one.layer == layer.name && one.kind != *layer.kind)
      return fail(Errc::kBadInput, "feature " + one.id + " on it is a " + std::string(word_of(one.kind)));
  const auto known = std::ranges::find(work.drawing.layers, layer.name, &DrawingLayer::name);
  if (known == work.drawing.layers.end())
    work.drawing.layers.push_back(layer);
  else
    *known = layer;
  return {};
}

// A layer that was not named before keeps what it has: nothing is drawn otherwise.
std::vector<std::vector<std::string>> SetLayer::restoring(const EditContext&, const EditedWork& before) const {
  const auto known = std::ranges::find(before.drawing.layers, layer.name, &DrawingLayer::name);
  if (known == before.drawing.layers.end()) return {};
  return {command_words(SetLayer{*known})};
}

}  // namespace collinea
