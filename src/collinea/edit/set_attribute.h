// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"
#include "collinea/vector/drawing.h"

namespace collinea {

struct EditedWork;

/// States something of a feature: `attribute F12 use shed`; `-` takes it back.
struct SetAttribute {
  static constexpr std::string_view kWord = "attribute";
  static constexpr std::string_view kForm = "attribute FEATURE NAME VALUE|-";
  static constexpr std::size_t kMost = 100, kLongestValue = 2000;

  std::string feature, name, value;

  static Result<SetAttribute> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<SetAttribute> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: no such feature; more than kMost attributes.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

/// Whether an attribute can be so. Errors: what is wrong with its name or its value.
[[nodiscard]] Result<> check_attribute(const std::string& name, const std::string& value);
/// Sets some of all attributes of a feature; "-" takes one back. Error, with nothing set: more than
/// SetAttribute::kMost.
[[nodiscard]] Result<> set_attributes(const std::map<std::string, std::string>& some,
                                      std::map<std::string, std::string>& all);

/// Names a layer of the drawing, with its colour and what is drawn on it: `layer roof polygon #e67e22`.
struct SetLayer {
  static constexpr std::string_view kWord = "layer";
  static constexpr std::string_view kForm = "layer LAYER point|line|polygon|any #RRGGBB";

  DrawingLayer layer;

  static Result<SetLayer> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<SetLayer> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Error: what is drawn on it is of another kind.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

}  // namespace collinea
