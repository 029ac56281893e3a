// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/internal/millimetre_camera.h"
#include "collinea/io/internal/xml.h"

namespace collinea {

/// A script of DBAT while it is read. Its parts are read by dbat_camera.h, dbat_tables.h and dbat_operations.h, in that
/// order; what none of them knows is an error.
struct DbatProject {
  std::filesystem::path script;      ///< for messages
  std::filesystem::path here, base;  ///< $HERE, the folder of the script; that of relative names
  MillimetreCamera loaded_camera;    ///< as the script or its camera file has it
  double nominal_focal_mm = 0;
  std::size_t radial_terms = 0, tangential_terms = 0;  ///< of the lens: nK, nP; others are no parameters of it
  AdjustmentFile file;

  /// Where a file lies that the script names. Error: in DBAT's own folder, which is not known here.
  [[nodiscard]] Result<std::filesystem::path> path_of(const XmlElement& in, std::string_view name) const;
};

[[nodiscard]] tl::unexpected<Error> bad_dbat(const std::filesystem::path& path, std::size_t line,
                                             const std::string& what);

/// Errors: a child of the element, or an attribute, that is none of these. Remarks (`c`) may stand everywhere.
[[nodiscard]] Result<> check_children(const XmlElement& element, std::initializer_list<std::string_view> known,
                                      const std::filesystem::path& path);
[[nodiscard]] Result<> check_attributes(const XmlElement& element, std::initializer_list<std::string_view> known,
                                        const std::filesystem::path& path);

[[nodiscard]] std::vector<const XmlElement*> children_named(const XmlElement& element, std::string_view name);

/// Numbers between commas, `least` to `most` of them. Errors: no number, another count.
[[nodiscard]] Result<std::vector<double>> dbat_numbers(const XmlElement& element, std::size_t least, std::size_t most,
                                                       const std::filesystem::path& path);

/// The document of a file, in UTF-8 or UTF-16.
[[nodiscard]] Result<XmlElement> read_xml(const std::filesystem::path& path);

}  // namespace collinea
