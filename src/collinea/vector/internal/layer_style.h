// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/vector/vector_layer.h"

namespace collinea {

/// The style of a layer as QGIS writes it (QML), in the form that all its versions from 3.0 on read: symbols with
/// properties, labels by a field. The layer has a style. Internal to the module.
[[nodiscard]] std::string qml_of(const VectorLayer& layer);

}  // namespace collinea
