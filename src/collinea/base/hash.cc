// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/hash.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <vector>

namespace collinea {

Hash& Hash::add(std::span<const std::byte> bytes) {
  constexpr std::uint64_t kPrime = 0x100000001b3u;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {  // eight bytes a step: images are long
    std::uint64_t word;
    std::memcpy(&word, bytes.data() + i, 8);
    state_ = (state_ ^ word) * kPrime;
    state_ ^= state_ >> 29;
  }
  for (; i < bytes.size(); ++i) state_ = (state_ ^ static_cast<std::uint64_t>(bytes[i])) * kPrime;
  return *this;
}

Hash& Hash::add(std::string_view text) {
  add(static_cast<std::uint64_t>(text.size()));
  return add(std::as_bytes(std::span(text.data(), text.size())));
}

Hash& Hash::add(std::uint64_t value) { return add(std::as_bytes(std::span(&value, 1))); }

std::uint64_t Hash::value() const {
  std::uint64_t mixed = state_;
  mixed = (mixed ^ (mixed >> 33)) * 0xff51afd7ed558ccdu;
  mixed = (mixed ^ (mixed >> 33)) * 0xc4ceb9fe1a85ec53u;
  return mixed ^ (mixed >> 33);
}

std::string Hash::hex() const { return fmt::format("{:016x}", value()); }

Result<std::uint64_t> hash_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(Errc::kNotFound, "cannot open " + path.string());
  Hash hash;
  std::vector<char> buffer(1 << 20);  // a multiple of eight, so that pieces do not change the fingerprint
  while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || file.gcount() > 0)
    hash.add(std::as_bytes(std::span(buffer.data(), static_cast<std::size_t>(file.gcount()))));
  if (file.bad()) return fail(Errc::kNotFound, path.string() + " cannot be read");
  return hash.value();
}

}  // namespace collinea
