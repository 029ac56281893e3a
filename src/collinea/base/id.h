// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace collinea {

/// An index that fits only the table it was made for: an ImageId is not a CameraId.
template <class Tag>
struct Id {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t value = kNone;

  [[nodiscard]] constexpr bool valid() const { return value != kNone; }
  friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

using CameraId = Id<struct CameraTag>;
using ImageId = Id<struct ImageTag>;
using PointId = Id<struct PointTag>;
using ControlId = Id<struct ControlTag>;

}  // namespace collinea

template <class Tag>
struct std::hash<collinea::Id<Tag>> {
  std::size_t operator()(collinea::Id<Tag> id) const noexcept { return std::hash<std::uint32_t>{}(id.value); }
};
