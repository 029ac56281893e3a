// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <source_location>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "collinea/base/option_name.h"

namespace collinea {

enum class Errc { kBadInput, kNotFound, kBadFormat, kUnsupported, kIllPosed, kNotConverged, kCancelled };

/// What went wrong in the world outside our code, in words a user can act on.
struct Error {
  Errc code;
  std::string message;
  std::vector<OptionName> options = {};  ///< those that are wrong, or that would help; a face names them behind

  /// Adds the caller's view of the failure in front: "reading block.json: camera 3: no such model".
  [[nodiscard]] Error within(std::string_view doing) && {
    message.insert(0, std::string(doing) + ": ");
    return std::move(*this);
  }
  /// Adds what to do about it behind: "...; remove that file and give the command again".
  [[nodiscard]] Error advising(std::string_view what) && {
    message += what;
    return std::move(*this);
  }
  /// Adds an option that it is about.
  [[nodiscard]] Error about(OptionName option) && {
    options.push_back(std::move(option));
    return std::move(*this);
  }
};

/// The value, or why there is none. Becomes std::expected when the project moves to C++23.
template <class T = void>
using Result = tl::expected<T, Error>;

/// Return this: fail(Errc::kBadInput, "the site has no extent: give its corners", {"area"_option}).
[[nodiscard]] inline tl::unexpected<Error> fail(Errc code, std::string message,
                                                std::initializer_list<OptionName> options = {}) {
  return tl::unexpected(Error{code, std::move(message), options});
}

/// A broken promise between two pieces of our own code: always a bug, never an error of the user.
[[noreturn]] void bug(std::string_view what, std::source_location at = std::source_location::current());

}  // namespace collinea

#define COLLINEA_CHECK(condition)  \
  do {                             \
    if (!(condition)) [[unlikely]] \
      ::collinea::bug(#condition); \
  } while (false)

#define COLLINEA_CONCAT_(a, b) a##b
#define COLLINEA_CONCAT(a, b) COLLINEA_CONCAT_(a, b)

/// COLLINEA_TRY(const Block block, read_block(path));  -- takes the value or returns the error to our caller.
/// COLLINEA_TRY(write_block(path, block));              -- goes on, or returns the error to our caller.
#define COLLINEA_TRY(...) COLLINEA_TRY_OF(__VA_ARGS__, COLLINEA_TRY_VALUE, COLLINEA_TRY_DONE, )(__VA_ARGS__)
#define COLLINEA_TRY_OF(first, second, form, ...) form
#define COLLINEA_TRY_DONE(expression)                               \
  if (auto collinea_try = (expression); !collinea_try) [[unlikely]] \
  return tl::unexpected(std::move(collinea_try).error())
#define COLLINEA_TRY_VALUE(declaration, expression)                                     \
  auto COLLINEA_CONCAT(collinea_try_, __LINE__) = (expression);                         \
  if (!COLLINEA_CONCAT(collinea_try_, __LINE__))                                        \
    return tl::unexpected(std::move(COLLINEA_CONCAT(collinea_try_, __LINE__)).error()); \
  declaration = *std::move(COLLINEA_CONCAT(collinea_try_, __LINE__))
