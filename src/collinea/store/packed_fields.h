// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "collinea/base/hash.h"
#include "collinea/base/id.h"
#include "collinea/base/options.h"
#include "collinea/base/packed.h"
#include "collinea/base/word_or.h"
#include "collinea/base/words.h"

namespace collinea {

// Structs as byte strings. A struct tells its members once, in their order and with their names,
//
//     template <class Visit>
//     static void fields(Visit&& visit) { visit("images", &DetectRecord::images); ... }
//
// and from that follow `pack`, `unpack` and `layout`. Members are numbers, booleans, enumerations, texts, ids, vectors
// and matrices of fixed size, words or else texts (WordOr), optional values, lists and maps of these, and structs that
// tell their members; options, which tell them by `describe`, too. Numbers come back bit by bit, NaN too.

namespace packing {

template <class T>
concept HasFields = requires {
  T::fields([](std::string_view, auto) {});
};
template <class T>
concept HasDescription = requires {
  T::describe([](const auto&) {});
};
template <class T>
concept FixedMatrix = requires {
  requires int(T::SizeAtCompileTime) > 0;
  typename T::Scalar;
};

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;
template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t N>
inline constexpr bool is_array<std::array<T, N>> = true;
template <class T>
inline constexpr bool is_map = false;
template <class K, class V>
inline constexpr bool is_map<std::map<K, V>> = true;
template <class T>
inline constexpr bool is_id = false;
template <class Tag>
inline constexpr bool is_id<Id<Tag>> = true;
template <class>
inline constexpr bool is_unknown = true;

/// Whether the enumeration has this value: by its words, or by a function is_known() beside it.
template <class T>
bool is_value(T value) {
  if constexpr (Worded<T>)
    return !word_of(value).empty();
  else if constexpr (requires { is_known(value); })
    return is_known(value);
  else
    return true;
}

/// visit(name, member) for each member of T, however T tells them.
template <class T, class Visit>
void for_each_member(Visit&& visit) {
  if constexpr (HasFields<T>)
    T::fields(visit);
  else
    T::describe([&](const auto& field) { visit(field.name, field.member); });
}

}  // namespace packing

/// Appends `value`.
template <class T>
void pack(Packer& packer, const T& value) {
  using namespace packing;
  if constexpr (std::is_same_v<T, bool>) {
    packer.put(std::uint8_t(value));
  } else if constexpr (std::is_arithmetic_v<T>) {
    packer.put(value);
  } else if constexpr (std::is_enum_v<T>) {
    packer.put(static_cast<std::underlying_type_t<T>>(value));
  } else if constexpr (is_id<T>) {
    packer.put(value.value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    packer.put(std::uint64_t(value.size()));
    packer.put_bytes(value);
  } else if constexpr (detail::kIsWordOr<T>) {
    pack(packer, value.text());
  } else if constexpr (is_optional<T>) {
    pack(packer, value.has_value());
    if (value) pack(packer, *value);
  } else if constexpr (is_list<T>) {
    packer.put(std::uint64_t(value.size()));
    for (const auto& one : value) pack(packer, one);
  } else if constexpr (is_array<T>) {
    for (const auto& one : value) pack(packer, one);
  } else if constexpr (is_map<T>) {
    packer.put(std::uint64_t(value.size()));
    for (const auto& [key, its] : value) {
      pack(packer, key);
      pack(packer, its);
    }
  } else if constexpr (HasFields<T> || HasDescription<T>) {
    for_each_member<T>([&](std::string_view, auto member) { pack(packer, value.*member); });
  } else if constexpr (FixedMatrix<T>) {
    for (int i = 0; i < int(T::SizeAtCompileTime); ++i) packer.put(value.data()[i]);
  } else {
    static_assert(!is_unknown<T>, "this type cannot be packed");
  }
}

/// Takes what `pack` wrote. False: the bytes end too early or hold what pack never writes; `value` is then of no use,
/// and no more memory was taken than a small multiple of the bytes.
template <class T>
[[nodiscard]] bool unpack(Unpacker& unpacker, T& value) {
  using namespace packing;
  if constexpr (std::is_same_v<T, bool>) {
    const auto byte = unpacker.get<std::uint8_t>();
    value = byte == 1;
    return unpacker.ok() && byte <= 1;
  } else if constexpr (std::is_arithmetic_v<T>) {
    unpacker.get(value);
    return unpacker.ok();
  } else if constexpr (std::is_enum_v<T>) {
    value = T(unpacker.get<std::underlying_type_t<T>>());
    return unpacker.ok() && is_value(value);
  } else if constexpr (is_id<T>) {
    unpacker.get(value.value);
    return unpacker.ok();
  } else if constexpr (std::is_same_v<T, std::string>) {
    const auto size = unpacker.get<std::uint64_t>();
    if (!unpacker.ok() || size > unpacker.left()) return false;
    value = unpacker.get_bytes(std::size_t(size));
    return true;
  } else if constexpr (detail::kIsWordOr<T>) {
    std::string text;
    if (!unpack(unpacker, text)) return false;
    value = text;
    return true;
  } else if constexpr (is_optional<T>) {
    bool has_value = false;
    if (!unpack(unpacker, has_value)) return false;
    value.reset();
    return !has_value || unpack(unpacker, value.emplace());
  } else if constexpr (is_list<T>) {
    const auto size = unpacker.get<std::uint64_t>();
    if (!unpacker.ok() || size > unpacker.left()) return false;  // nothing is shorter than a byte
    value.clear();
    for (std::uint64_t i = 0; i < size; ++i)
      if (!unpack(unpacker, value.emplace_back())) return false;
    return true;
  } else if constexpr (is_array<T>) {
    for (auto& one : value)
      if (!unpack(unpacker, one)) return false;
    return true;
  } else if constexpr (is_map<T>) {
    const auto size = unpacker.get<std::uint64_t>();
    if (!unpacker.ok() || size > unpacker.left()) return false;
    value.clear();
    for (std::uint64_t i = 0; i < size; ++i) {
      typename T::key_type key{};
      if (!unpack(unpacker, key)) return false;
      if (!value.empty() && !(value.rbegin()->first < key)) return false;
      if (!unpack(unpacker, value.emplace_hint(value.end(), std::move(key), typename T::mapped_type{})->second))
        return false;
    }
    return true;
  } else if constexpr (HasFields<T> || HasDescription<T>) {
    bool whole = true;
    for_each_member<T>([&](std::string_view, auto member) { whole = whole && unpack(unpacker, value.*member); });
    return whole;
  } else if constexpr (FixedMatrix<T>) {
    for (int i = 0; i < int(T::SizeAtCompileTime); ++i) unpacker.get(value.data()[i]);
    return unpacker.ok();
  } else {
    static_assert(!is_unknown<T>, "this type cannot be unpacked");
  }
}

namespace packing {

/// What the values of an enumeration mean: its table of words, or word_of() of all values from 0 on that is_known()
/// beside it knows. Bytes that were written before its values changed their order are then of another layout.
template <class T>
void add_meaning(Hash& hash) {
  if constexpr (Worded<T>) {
    for (const auto& entry : words(T{})) hash.add(std::uint64_t(entry.value)).add(entry.word);
  } else if constexpr (requires(const T value) { is_known(value), word_of(value); }) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::underlying_type_t<T>>::max();
    for (std::uint64_t i = 0; i <= kMost && is_known(T(i)); ++i) hash.add(word_of(T(i)));
  } else {
    static_assert(!is_unknown<T>, "an enumeration that is packed needs words for its values");
  }
}

template <class T>
void add_layout(Hash& hash) {
  if constexpr (std::is_arithmetic_v<T>) {
    hash.add(std::is_floating_point_v<T> ? "real" : std::is_signed_v<T> ? "integer" : "count").add(sizeof(T));
  } else if constexpr (std::is_enum_v<T>) {
    hash.add("choice").add(sizeof(T));
    add_meaning<T>(hash);
  } else if constexpr (is_id<T>) {
    hash.add("id");
  } else if constexpr (std::is_same_v<T, std::string> || detail::kIsWordOr<T>) {
    hash.add("text");
  } else if constexpr (is_optional<T> || is_list<T>) {
    hash.add(is_list<T> ? "list" : "optional");
    add_layout<typename T::value_type>(hash);
  } else if constexpr (is_array<T>) {
    hash.add("array").add(std::tuple_size_v<T>);
    add_layout<typename T::value_type>(hash);
  } else if constexpr (is_map<T>) {
    hash.add("map");
    add_layout<typename T::key_type>(hash);
    add_layout<typename T::mapped_type>(hash);
  } else if constexpr (HasFields<T> || HasDescription<T>) {
    hash.add("struct");
    for_each_member<T>([&]<class Member>(std::string_view name, Member T::*) {
      hash.add(name);
      add_layout<Member>(hash);
    });
    hash.add("end");
  } else {
    hash.add("matrix").add(std::size_t(T::SizeAtCompileTime)).add(sizeof(typename T::Scalar));
  }
}

}  // namespace packing

/// A fingerprint of names, kinds and order of all members of T, and of the words of enumerations: bytes that were
/// packed with another one are of another version of the program.
template <class T>
[[nodiscard]] std::uint64_t layout() {
  Hash hash;
  packing::add_layout<T>(hash);
  return hash.value();
}

}  // namespace collinea
