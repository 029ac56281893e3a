// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace collinea {

/// Whether a header `Accept-Encoding` allows gzip (RFC 9110, 12.5.3): named, or meant by "*", with a weight that is not
/// 0.
[[nodiscard]] bool allows_gzip(std::string_view accept_encoding);

}  // namespace collinea
