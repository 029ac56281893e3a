// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

// Text files taken apart the same way in every locale. Views point into the caller's text.

[[nodiscard]] std::string_view trimmed(std::string_view text);  ///< without white space at both ends
[[nodiscard]] std::string lower(std::string_view text);         ///< ASCII letters only

/// The UTF-8 of a file that begins with a byte order mark of UTF-16, in either order of bytes; nothing when the bytes
/// are UTF-8 (or any other extension of ASCII) already. Errors: UTF-16 without that mark, UTF-32, half a pair of
/// UTF-16, and bytes of 0, which no text has: another program's own format.
[[nodiscard]] Result<std::optional<std::string>> converted_to_utf8(std::string_view bytes);

/// Lines without their ends (LF, CRLF, CR); a byte order mark in front is dropped.
[[nodiscard]] std::vector<std::string_view> lines_of(std::string_view text);
/// The parts between runs of white space.
[[nodiscard]] std::vector<std::string_view> words_of(std::string_view line);
/// The parts between single separators, trimmed; "a,,b" has three.
[[nodiscard]] std::vector<std::string_view> fields_of(std::string_view line, char separator);

/// The number that the whole text is; "nan" and "inf" count, a leading plus sign is allowed.
[[nodiscard]] std::optional<double> number(std::string_view text);
[[nodiscard]] std::optional<double> finite_number(std::string_view text);  ///< without these two
[[nodiscard]] std::optional<std::int64_t> integer(std::string_view text);

/// The shortest digits that read back as the same double.
[[nodiscard]] std::string exact(double value);
/// With a fixed number of digits behind the point.
[[nodiscard]] std::string fixed(double value, int decimals);
/// "2.5 mm", "0.31 m".
[[nodiscard]] std::string metres_text(double m);

}  // namespace collinea
