// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// Text that is bytes of a file: the description in a TIFF, the head of a PLY, the titles of columns, well-known text
/// of a CRS. It says to readers of the file what it holds, belongs to its format, and stays as it is whatever a face
/// says and in whatever language. What a face says is made in `report` and `app`.
using FileText = const char*;

}  // namespace collinea
