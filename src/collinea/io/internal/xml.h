// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// An element of an XML document, with what stands in it.
struct XmlElement {
  std::string name, text;
  std::map<std::string, std::string> attributes;
  std::vector<XmlElement> children;
  std::size_t line = 0;

  [[nodiscard]] const XmlElement* child(std::string_view wanted) const {
    const auto its =
        std::find_if(children.begin(), children.end(), [&](const XmlElement& e) { return e.name == wanted; });
    return its == children.end() ? nullptr : &*its;
  }
  /// Empty where there is no such attribute.
  [[nodiscard]] const std::string& attribute(const std::string& wanted) const {
    static const std::string kNone;
    const auto its = attributes.find(wanted);
    return its == attributes.end() ? kNone : its->second;
  }
};

/// The root element of as much of XML 1.0 as scripts of DBAT use: elements, attributes in double or single quotes,
/// text, comments, CDATA, <?...?>, the five named entities and those by number; no document type. An attribute comes
/// once. Elements `c` and `meta` are remarks, which may hold anything. An error names the line.
[[nodiscard]] Result<XmlElement> parse_xml(std::string_view text);

}  // namespace collinea
