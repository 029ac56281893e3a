// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/line_names.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/io/text.h"

namespace collinea {
namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

}  // namespace

std::string escaped_name(std::string_view name) {
  std::string shown;
  for (const char c : name) {
    if (c == '\n')
      shown += "\\n";
    else if (c == '\r')
      shown += "\\r";
    else if (c == '\t')
      shown += "\\t";
    else if (is_control(c))
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      shown += c;
  }
  return shown;
}

bool has_control_character(std::string_view name) { return std::any_of(name.begin(), name.end(), is_control); }

Result<> check_image_names(const Block& block, std::string_view format, bool hash_begins_remark) {
  for (const auto& [id, pose] : oriented_images(block)) {
    const std::string& name = block.images.at(id).file;
    const char* why = name.empty()                                  ? "is empty"
                      : has_control_character(name)                 ? "holds a line break, tab or control character"
                      : trimmed(name).size() < name.size()          ? "begins or ends with a blank"
                      : hash_begins_remark && name.starts_with('#') ? "begins with #"
                                                                    : nullptr;
    if (why)
      return fail(Errc::kUnsupported, fmt::format("the name of image \"{}\" {}, which {} cannot hold: rename the file",
                                                  escaped_name(name), why, format));
  }
  return {};
}

}  // namespace collinea
