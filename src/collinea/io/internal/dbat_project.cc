// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/dbat_project.h"

#include <algorithm>
#include <cstdlib>

#include "collinea/base/file.h"
#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

std::string listed(std::initializer_list<std::string_view> names) {
  std::string text;
  for (const std::string_view name : names) text += (text.empty() ? "" : ", ") + std::string(name);
  return text.empty() ? "none" : text;
}

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> known) {
  return std::find(known.begin(), known.end(), name) != known.end();
}

// The name behind "$HERE" or the like; nothing where it does not begin so.
std::optional<std::string> behind(std::string_view folder, const std::string& name) {
  if (!name.starts_with(folder) || (name.size() > folder.size() && name[folder.size()] != '/')) return std::nullopt;
  const auto rest = name.find_first_not_of('/', folder.size());
  return rest == std::string::npos ? std::string{} : name.substr(rest);
}

}  // namespace

Result<std::filesystem::path> DbatProject::path_of(const XmlElement& in, std::string_view name) const {
  std::string plain(trimmed(name));
  std::replace(plain.begin(), plain.end(), '\\', '/');
  if (plain.empty()) return bad_dbat(script, in.line, "element " + in.name + " names no file");
  if (const auto rest = behind("$HERE", plain)) return here / *rest;
  if (const auto rest = behind("$HOME", plain))
    if (const char* home = std::getenv("HOME")) return std::filesystem::path(home) / *rest;
  if (behind("$DBAT", plain))
    return bad_dbat(
        script, in.line,
        plain + ": where DBAT is installed is not known here; write the folder, or $HERE for that of the script");
  const std::filesystem::path path(plain);
  return path.is_absolute() ? path : base / path;
}

tl::unexpected<Error> bad_dbat(const std::filesystem::path& path, std::size_t line, const std::string& what) {
  return fail(Errc::kBadFormat, path.string() + ": line " + std::to_string(line) + ": " + what);
}

Result<> check_children(const XmlElement& element, std::initializer_list<std::string_view> known,
                        const std::filesystem::path& path) {
  for (const XmlElement& child : element.children)
    if (child.name != "c" && !is_one_of(child.name, known))
      return bad_dbat(path, child.line,
                      "element " + child.name + " in " + element.name +
                          ": this reader does not know it; there are: " + listed(known));
  return {};
}

Result<> check_attributes(const XmlElement& element, std::initializer_list<std::string_view> known,
                          const std::filesystem::path& path) {
  for (const auto& [name, value] : element.attributes)
    if (!is_one_of(name, known))
      return bad_dbat(
          path, element.line,
          "attribute " + name + " of " + element.name + ": this reader does not know it; there are: " + listed(known));
  return {};
}

std::vector<const XmlElement*> children_named(const XmlElement& element, std::string_view name) {
  std::vector<const XmlElement*> found;
  for (const XmlElement& child : element.children)
    if (child.name == name) found.push_back(&child);
  return found;
}

Result<std::vector<double>> dbat_numbers(const XmlElement& element, std::size_t least, std::size_t most,
                                         const std::filesystem::path& path) {
  std::vector<double> values;
  if (!trimmed(element.text).empty() || least > 0)
    for (const std::string_view field : fields_of(element.text, ',')) {
      const auto value = finite_number(field);
      if (!value)
        return bad_dbat(path, element.line,
                        element.name + ": \"" + std::string(field) + "\" is no number" + number_hint(field));
      values.push_back(*value);
    }
  if (values.size() >= least && values.size() <= most) return values;
  return bad_dbat(path, element.line,
                  element.name + " has " + std::to_string(values.size()) + " numbers; " +
                      (least == most ? std::to_string(least) : std::to_string(least) + " to " + std::to_string(most)) +
                      (most == 1 ? " is" : " are") + " expected");
}

Result<XmlElement> read_xml(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string bytes, read_file(path));
  const auto parse = [&]() -> Result<XmlElement> {
    COLLINEA_TRY(const auto converted, converted_to_utf8(bytes));
    return parse_xml(converted ? *converted : bytes);
  };
  return parse().map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace collinea
