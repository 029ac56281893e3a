// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/control_contents.h"

namespace collinea {

/// A format of control files. Each has a file of its own (`gcp_list_control.cc`), which defines the function below, and
/// an example in docs/manual/import.md, from which the laws of all formats are tested (control_file_test.cc).
struct ControlFormat {
  std::string_view name;  ///< as the manual heads its example
  bool (*recognises)(std::string_view text);
  Result<ControlFile> (*parse)(std::string_view text, const ControlDefaults& defaults);
};

[[nodiscard]] ControlFormat csv_control();
[[nodiscard]] ControlFormat gcp_list_control();

/// The only list of formats, in the order in which they are asked; the last takes whatever is left.
[[nodiscard]] inline auto control_formats() { return std::array{csv_control(), gcp_list_control()}; }

}  // namespace collinea
