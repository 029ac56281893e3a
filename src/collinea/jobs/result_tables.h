// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// Writes tables into a folder, which is made when missing.
[[nodiscard]] inline Result<> write_result_tables(const std::vector<NamedTable>& tables,
                                                  const std::filesystem::path& folder) {
  COLLINEA_TRY(make_out_folder(folder));
  for (const NamedTable& table : tables) COLLINEA_TRY(write_file(folder / table.name, text_of(table.table)));
  return {};
}

}  // namespace collinea
