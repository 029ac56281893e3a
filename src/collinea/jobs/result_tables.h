// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/report/findings_text.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// Writes tables into a folder, which is made when missing.
[[nodiscard]] inline Result<> write_result_tables(const std::vector<NamedTable>& tables,
                                                  const std::filesystem::path& folder) {
  COLLINEA_TRY(make_out_folder(folder));
  for (const NamedTable& table : tables) COLLINEA_TRY(write_file(folder / table.name, text_of(table.table)));
  return {};
}

/// And findings.json beside them.
[[nodiscard]] inline Result<> write_result_tables(const std::vector<NamedTable>& tables,
                                                  std::span<const Finding> findings,
                                                  const std::filesystem::path& folder) {
  COLLINEA_TRY(write_result_tables(tables, folder));
  return write_file(folder / "findings.json", findings_json_text(findings));
}

}  // namespace collinea
