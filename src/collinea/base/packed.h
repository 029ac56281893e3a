// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace collinea {

namespace detail {
template <std::size_t Size>
struct UnsignedOf;
template <>
struct UnsignedOf<1> {
  using type = std::uint8_t;
};
template <>
struct UnsignedOf<2> {
  using type = std::uint16_t;
};
template <>
struct UnsignedOf<4> {
  using type = std::uint32_t;
};
template <>
struct UnsignedOf<8> {
  using type = std::uint64_t;
};

/// The bits of a number in little-endian byte order, whatever the machine's is.
template <class T>
requires std::is_arithmetic_v<T>
constexpr auto little_endian_bits(T value) {
  using U = typename UnsignedOf<sizeof(T)>::type;
  U bits = std::bit_cast<U>(value);
  if constexpr (std::endian::native == std::endian::big) {
    U swapped = 0;
    for (std::size_t i = 0; i < sizeof(U); ++i)
      swapped = U(swapped | U(((bits >> (8 * i)) & 0xff) << (8 * (sizeof(U) - 1 - i))));
    bits = swapped;
  }
  return bits;
}
}  // namespace detail

/// Builds a little-endian byte string: numbers bit by bit, without padding. What binary files and database blobs hold.
class Packer {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) {
    const auto bits = detail::little_endian_bits(value);
    bytes_.append(reinterpret_cast<const char*>(&bits), sizeof(bits));
  }
  void put_bytes(std::string_view bytes) { bytes_.append(bytes); }
  /// `text` cut or filled with zeros to exactly `size` bytes.
  void put_text(std::string_view text, std::size_t size) {
    bytes_.append(text.substr(0, size));
    if (text.size() < size) bytes_.append(size - text.size(), '\0');
  }
  void reserve(std::size_t size) { bytes_.reserve(size); }
  void clear() { bytes_.clear(); }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Takes a byte string of Packer apart. Reading beyond its end gives zeros and is remembered: look at ok() before what
/// was read is trusted.
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    using U = typename detail::UnsignedOf<sizeof(T)>::type;
    if (rest_.size() < sizeof(T)) {
      ok_ = false;
      rest_ = {};
      return T{};
    }
    U bits;
    std::memcpy(&bits, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return std::bit_cast<T>(detail::little_endian_bits(bits));
  }
  template <class T>
  void get(T& value) {
    value = get<T>();
  }
  /// The next `size` bytes; fewer, and not ok, at the end.
  std::string_view get_bytes(std::size_t size) {
    if (rest_.size() < size) {
      ok_ = false;
      size = rest_.size();
    }
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool done() const { return ok_ && rest_.empty(); }  ///< all was read, nothing missed
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace collinea
