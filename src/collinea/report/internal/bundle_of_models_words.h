// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/io/text_table.h"
#include "collinea/orient/bundle_of_models.h"

namespace collinea {

/// For a terminal: counts and sigma0 of the bundle, how far joined models are from it, and the ratio of their sigmas.
[[nodiscard]] std::string bundle_text(const JoinedBlock& models, const BundleOfModels& bundle);

/// Coordinates and sigmas of the bundle, models minus bundle, and their sigmas over its: twelve columns, and the fields
/// of a point ("-" where the bundle has none).
void add_bundle_columns(TextTable& table);
void add_bundle_fields(const JoinedPoint& point, const BundleOfModels& bundle, std::vector<std::string>& row);

}  // namespace collinea
