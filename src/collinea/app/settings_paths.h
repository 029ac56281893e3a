// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/project/settings.h"

namespace collinea {

/// Makes the paths among the options absolute, so that the project can be worked on from any folder; text that may be
/// the name of a file only when there is that file.
void make_paths_absolute(Settings& settings);

}  // namespace collinea
