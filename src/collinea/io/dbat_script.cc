// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/dbat_script.h"

#include "collinea/io/internal/dbat_camera.h"
#include "collinea/io/internal/dbat_operations.h"
#include "collinea/io/internal/dbat_tables.h"
#include "collinea/io/text.h"

namespace collinea {

Result<AdjustmentFile> read_dbat_script(const std::filesystem::path& path) {
  COLLINEA_TRY(const XmlElement script, read_xml(path));
  const XmlElement* input = script.child("input");
  if (!input) return fail(Errc::kBadFormat, path.string() + ": there is no element input: not a script of DBAT");
  if (const std::string version = script.attribute("dbat_script_version"); !version.starts_with("1."))
    return bad_dbat(path, script.line, "dbat_script_version " + version + ": this reader knows version 1");
  COLLINEA_TRY(check_children(script, {"input", "operations", "output", "meta"}, path));
  COLLINEA_TRY(check_children(*input, {"ctrl_pts", "check_pts", "images", "prior_eo", "image_pts", "cameras"}, path));
  COLLINEA_TRY(check_attributes(*input, {"base_dir"}, path));
  DbatProject project;
  project.script = path;
  project.here = project.base = path.parent_path();
  if (const std::string base = input->attribute("base_dir"); !base.empty()) {
    COLLINEA_TRY(project.base, project.path_of(*input, base));
  }
  COLLINEA_TRY(read_dbat_camera(*input, project));
  COLLINEA_TRY(read_dbat_tables(*input, project));
  if (const XmlElement* operations = script.child("operations"))
    COLLINEA_TRY(apply_dbat_operations(*operations, project));
  return std::move(project.file);
}

bool is_dbat_script(std::string_view bytes) {
  constexpr std::size_t kHead = 65536;  // remarks may stand in front
  const std::string_view head = bytes.substr(0, kHead);
  const auto converted = converted_to_utf8(head);
  return (converted && *converted ? std::string_view(**converted) : head).find("dbat_script_version") !=
         std::string_view::npos;
}

}  // namespace collinea
