// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace collinea {

/// How often each of 2 to 2048 symbols came so far, as the interval [0, 2^15) cut into parts. Adaptive model of Said
/// (2004), "Introduction to Arithmetic Coding", with the constants LAZ fixes.
class SymbolModel {
 public:
  explicit SymbolModel(std::uint32_t symbols);

 private:
  friend class ArithmeticEncoder;
  friend class ArithmeticDecoder;
  void count(std::uint32_t symbol) {
    ++counts_[symbol];
    if (--until_update_ == 0) update();
  }
  void update();
  std::vector<std::uint32_t> begins_, counts_;  // begin of each symbol's part; occurrences
  std::uint32_t total_ = 0, cycle_ = 0, until_update_ = 0;
};

/// The same for a single bit, with 2^13 parts.
class BitModel {
 private:
  friend class ArithmeticEncoder;
  friend class ArithmeticDecoder;
  void count(bool bit) {
    zeros_ += !bit;
    if (--until_update_ == 0) update();
  }
  void update();
  std::uint32_t zero_part_ = 1u << 12, zeros_ = 1, total_ = 2, cycle_ = 4, until_update_ = 4;
};

/// Arithmetic coder with 32 bits (Said 2004). Each function returns what it was given, so that one description of a
/// format serves this class and ArithmeticDecoder.
class ArithmeticEncoder {
 public:
  std::uint32_t symbol(SymbolModel& model, std::uint32_t symbol);
  bool bit(BitModel& model, bool bit);
  std::uint32_t raw(int bits, std::uint32_t value);  ///< 1 to 32 bits without a model
  std::string finish();                              ///< all bytes; nothing may be coded afterwards

 private:
  void advance(std::uint32_t offset);
  void shift_out();
  std::string bytes_;
  std::uint32_t low_ = 0, length_ = ~0u;
};

/// Its inverse; arguments that say the value are ignored. Damaged bytes give wrong values but never values out of
/// range; reading beyond the end gives zeros and is remembered.
class ArithmeticDecoder {
 public:
  ArithmeticDecoder() = default;
  explicit ArithmeticDecoder(std::string_view bytes);
  std::uint32_t symbol(SymbolModel& model, std::uint32_t = 0);
  bool bit(BitModel& model, bool = false);
  std::uint32_t raw(int bits, std::uint32_t = 0);
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  std::uint32_t next_byte();
  void shift_in();
  std::string_view rest_;
  std::uint32_t value_ = 0, length_ = ~0u;
  bool ok_ = true;
};

/// Codes a 32-bit number as its difference from a prediction: the number of bits of the difference by a model of the
/// context, the upper eight bits of it by a model of that number of bits, the rest raw.
class NumberModel {
 public:
  explicit NumberModel(std::uint32_t contexts);
  /// Coder: ArithmeticEncoder or ArithmeticDecoder. Returns the number.
  template <class Coder>
  std::int32_t code(Coder& coder, std::int32_t predicted, std::int32_t number, std::uint32_t context);
  [[nodiscard]] std::uint32_t bits() const { return bits_; }  ///< of the last difference

 private:
  template <class Coder>
  std::uint32_t code_within(Coder& coder, std::uint32_t position);
  std::vector<SymbolModel> sizes_, positions_;
  BitModel small_;
  std::uint32_t bits_ = 0;
};

}  // namespace collinea
