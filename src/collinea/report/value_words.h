// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "collinea/camera/camera.h"
#include "collinea/quality/variance_components.h"
#include "collinea/report/internal/report_input.h"

namespace collinea {

/// Words for values of the modules below, as tables and sentences of reports name them.

/// "control, plan"; of observations of the adjustment.
[[nodiscard]] std::string_view words_of(ObservationGroup group);

/// "EXIF 35 mm equivalent"; empty of an unknown one.
[[nodiscard]] std::string_view words_of(Provenance source);

/// "above the WGS 84 ellipsoid".
[[nodiscard]] std::string_view words_of(HeightReference heights);

/// Options that were chosen, by name and value; ("all", "as by default") when none was.
[[nodiscard]] NamedValues chosen_options(const ReportInput& input);

/// Parameters of cameras that are fixed because the additional ones do the same; empty: none.
[[nodiscard]] std::string fixed_instead_words(const std::vector<std::string>& parameters);

/// What orientation found of what was given: by how much it multiplied sigmas, and by how much it shifted the positions
/// [m], zero when they stay. "sigmas of "control, plan" times 1.7, positions shifted by +0.10, -0.02, +1.30 m"; empty
/// when all is as given.
[[nodiscard]] std::string judgement_words(const SigmaFactors& factors, const Eigen::Vector3d& position_shift_m);

}  // namespace collinea
