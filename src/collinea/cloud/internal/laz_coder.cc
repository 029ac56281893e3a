// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/internal/laz_coder.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "collinea/base/result.h"

namespace collinea {
namespace {

// Constants of the format: another value would be another format.
constexpr int kSymbolBits = 15, kBitBits = 13;
constexpr std::uint32_t kShortest = 1u << 24;  // of the coder's interval before a byte is shifted out
constexpr std::uint32_t kHighBits = 8;         // of a difference that have a model

}  // namespace

SymbolModel::SymbolModel(std::uint32_t symbols) : begins_(symbols), counts_(symbols, 1), cycle_(symbols) {
  COLLINEA_CHECK(symbols >= 2 && symbols <= 2048);
  update();
  until_update_ = cycle_ = (symbols + 6) / 2;
}

void SymbolModel::update() {
  total_ += cycle_;
  if (total_ > 1u << kSymbolBits) {  // halved: what was long ago counts less
    total_ = 0;
    for (std::uint32_t& count : counts_) total_ += count = (count + 1) / 2;
  }
  const std::uint32_t scale = (1u << 31) / total_;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    begins_[i] = (scale * sum) >> (31 - kSymbolBits);
    sum += counts_[i];
  }
  cycle_ = std::min(5 * cycle_ / 4, std::uint32_t(counts_.size() + 6) * 8);
  until_update_ = cycle_;
}

void BitModel::update() {
  total_ += cycle_;
  if (total_ > 1u << kBitBits) {
    total_ = (total_ + 1) / 2;
    zeros_ = (zeros_ + 1) / 2;
    total_ += zeros_ == total_;
  }
  zero_part_ = (zeros_ * ((1u << 31) / total_)) >> (31 - kBitBits);
  cycle_ = std::min(5 * cycle_ / 4, 64u);
  until_update_ = cycle_;
}

// --- encoder ---------------------------------------------------------------------------------------------------------

void ArithmeticEncoder::advance(std::uint32_t offset) {
  low_ += offset;
  if (low_ >= offset) return;
  std::size_t i = bytes_.size();  // the carry goes into the bytes already out
  while (std::uint8_t(bytes_[--i]) == 0xff) bytes_[i] = 0;
  bytes_[i] = char(std::uint8_t(bytes_[i]) + 1);
}

void ArithmeticEncoder::shift_out() {
  while (length_ < kShortest) {
    bytes_.push_back(char(low_ >> 24));
    low_ <<= 8;
    length_ <<= 8;
  }
}

std::uint32_t ArithmeticEncoder::symbol(SymbolModel& model, std::uint32_t symbol) {
  const std::uint32_t unit = length_ >> kSymbolBits, begin = model.begins_[symbol] * unit;
  const bool last = symbol + 1 == model.begins_.size();
  length_ = (last ? length_ : model.begins_[symbol + 1] * unit) - begin;
  advance(begin);
  shift_out();
  model.count(symbol);
  return symbol;
}

bool ArithmeticEncoder::bit(BitModel& model, bool bit) {
  const std::uint32_t zero = model.zero_part_ * (length_ >> kBitBits);
  length_ = bit ? length_ - zero : zero;
  if (bit) advance(zero);
  shift_out();
  model.count(bit);
  return bit;
}

std::uint32_t ArithmeticEncoder::raw(int bits, std::uint32_t value) {
  if (bits > 19) {  // lower half first
    raw(16, value & 0xffff);
    raw(bits - 16, value >> 16);
    return value;
  }
  length_ >>= bits;
  advance(value * length_);
  shift_out();
  return value;
}

std::string ArithmeticEncoder::finish() {
  // A number within the interval with as few bytes as do, then zeros: a decoder has read four bytes ahead.
  const bool wide = length_ > 2 * kShortest;
  advance(wide ? kShortest : kShortest / 2);
  length_ = wide ? kShortest / 2 : kShortest / 512;
  shift_out();
  bytes_.append(wide ? 3 : 2, '\0');
  return std::move(bytes_);
}

// --- decoder ---------------------------------------------------------------------------------------------------------

ArithmeticDecoder::ArithmeticDecoder(std::string_view bytes) : rest_(bytes) {
  for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next_byte();
}

std::uint32_t ArithmeticDecoder::next_byte() {
  if (rest_.empty()) {
    ok_ = false;
    return 0;
  }
  const auto byte = std::uint8_t(rest_.front());
  rest_.remove_prefix(1);
  return byte;
}

void ArithmeticDecoder::shift_in() {
  while (length_ < kShortest) {
    value_ = value_ << 8 | next_byte();
    length_ <<= 8;
  }
}

std::uint32_t ArithmeticDecoder::symbol(SymbolModel& model, std::uint32_t) {
  const std::vector<std::uint32_t>& begins = model.begins_;
  const std::uint32_t unit = length_ >> kSymbolBits, position = value_ / unit;
  const auto symbol = std::uint32_t(std::upper_bound(begins.begin() + 1, begins.end(), position) - begins.begin() - 1);
  const std::uint32_t begin = begins[symbol] * unit;
  length_ = (symbol + 1 == begins.size() ? length_ : begins[symbol + 1] * unit) - begin;
  value_ -= begin;
  shift_in();
  model.count(symbol);
  return symbol;
}

bool ArithmeticDecoder::bit(BitModel& model, bool) {
  const std::uint32_t zero = model.zero_part_ * (length_ >> kBitBits);
  const bool bit = value_ >= zero;
  length_ = bit ? length_ - zero : zero;
  if (bit) value_ -= zero;
  shift_in();
  model.count(bit);
  return bit;
}

std::uint32_t ArithmeticDecoder::raw(int bits, std::uint32_t) {
  if (bits > 19) {
    const std::uint32_t lower = raw(16);
    return raw(bits - 16) << 16 | lower;
  }
  length_ >>= bits;
  const std::uint32_t value = std::min(value_ / length_, (1u << bits) - 1);  // more only in damaged bytes
  value_ -= value * length_;
  shift_in();
  return value;
}

// --- numbers ---------------------------------------------------------------------------------------------------------

NumberModel::NumberModel(std::uint32_t contexts) : sizes_(contexts, SymbolModel(33)) {
  for (std::uint32_t bits = 1; bits < 32; ++bits) positions_.emplace_back(1u << std::min(bits, kHighBits));
}

template <class Coder>
std::uint32_t NumberModel::code_within(Coder& coder, std::uint32_t position) {
  SymbolModel& model = positions_[bits_ - 1];
  if (bits_ <= kHighBits) return coder.symbol(model, position);
  const std::uint32_t raw_bits = bits_ - kHighBits;
  const std::uint32_t high = coder.symbol(model, position >> raw_bits);
  return high << raw_bits | coder.raw(int(raw_bits), position & ((1u << raw_bits) - 1));
}

// Differences of 0 and 1 have 0 bits; k bits are the numbers -(2^k - 1) .. -2^(k-1), then 2^(k-1) + 1 .. 2^k.
template <class Coder>
std::int32_t NumberModel::code(Coder& coder, std::int32_t predicted, std::int32_t number, std::uint32_t context) {
  std::uint32_t difference = std::uint32_t(number) - std::uint32_t(predicted);
  const bool positive = std::int32_t(difference) > 0;
  bits_ = coder.symbol(sizes_[context], std::uint32_t(std::bit_width(positive ? difference - 1 : 0u - difference)));
  if (bits_ == 0) {
    difference = coder.bit(small_, difference == 1);
  } else if (bits_ == 32) {
    difference = 1u << 31;
  } else {
    const std::uint32_t span = (1u << bits_) - 1;
    const std::uint32_t position = code_within(coder, positive ? difference - 1 : difference + span);
    difference = position >> (bits_ - 1) ? position + 1 : position - span;
  }
  return std::int32_t(std::uint32_t(predicted) + difference);
}

template std::int32_t NumberModel::code(ArithmeticEncoder&, std::int32_t, std::int32_t, std::uint32_t);
template std::int32_t NumberModel::code(ArithmeticDecoder&, std::int32_t, std::int32_t, std::uint32_t);

}  // namespace collinea
