// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <optional>

#include "collinea/base/packed.h"
#include "collinea/cloud/internal/laz.h"
#include "collinea/cloud/internal/laz_coder.h"

namespace collinea {
namespace {

constexpr std::size_t kPointLayers = 9;  // x and y, z, class, flags, intensity, angle, user data, source, time
constexpr std::size_t kReturnsAt = 14, kFlagsAt = 15, kClassAt = 16, kColourAt = 30;

template <class T>
T load(const char* bytes) {
  return Unpacker(std::string_view(bytes, sizeof(T))).get<T>();
}
template <class T>
void store(T value, char* bytes) {
  const auto bits = detail::little_endian_bits(value);
  std::memcpy(bytes, &bits, sizeof(bits));
}

// The median of the last numbers, nearly: of five sorted ones the largest or the smallest makes room in turn, so that
// the third stays in the middle.
class RunningMedian {
 public:
  [[nodiscard]] std::int32_t value() const { return sorted_[2]; }
  void add(std::int32_t number) {
    const std::int32_t median = sorted_[2];
    if (drop_largest_) {
      std::size_t i = 4;
      for (; i > 0 && number < sorted_[i - 1]; --i) sorted_[i] = sorted_[i - 1];
      sorted_[i] = number;
      drop_largest_ = number < median;
    } else {
      std::size_t i = 0;
      for (; i < 4 && sorted_[i + 1] < number; ++i) sorted_[i] = sorted_[i + 1];
      sorted_[i] = number;
      drop_largest_ = number <= median;
    }
  }

 private:
  std::array<std::int32_t, 5> sorted_{};
  bool drop_largest_ = true;
};

// The layers of a chunk that vary in clouds of images.
template <class Coder>
struct Layers {
  Coder plan, height, colour;
  std::optional<Coder> classes;  // none: all have the class of the first point
  bool has_colour = true;
  std::vector<std::optional<Coder>> extra;
};

std::uint32_t colour_changes(const std::array<std::uint16_t, 3>& last, const std::array<std::uint16_t, 3>& now) {
  std::uint32_t changes = 0;
  for (std::uint32_t i = 0; i < 3; ++i) {
    const int bits = last[i] ^ now[i];
    changes |= std::uint32_t((bits & 0xff) != 0) << (2 * i) | std::uint32_t((bits & 0xff00) != 0) << (2 * i + 1);
  }
  return changes | std::uint32_t(now[0] != now[1] || now[0] != now[2]) << 6;
}

int byte_of(std::uint16_t channel, int high) { return high ? channel >> 8 : channel & 0xff; }

// The models of one chunk, and the last point's state: one description for both directions.
class ChunkModels {
 public:
  explicit ChunkModels(const LazLayout& layout) : layout_(layout), bytes_(layout.extra_bytes, SymbolModel(256)) {}

  // Codes `record` after `last`; a decoder fills it in. False: something that only laser scanners write.
  template <class Coder>
  bool code(Layers<Coder>& layers, const char* last, char* record) {
    const std::uint32_t changes = layers.plan.symbol(changes_[time_changed_ ? 7 : 3], 0);
    if (changes & 0b1000111) return false;  // return number, number of returns, channel
    time_changed_ = changes & 0b10000;
    code_position(layers, last, record);
    if (layers.classes) {
      SymbolModel& model = class_model(std::uint8_t(last[kClassAt]) & 31);
      record[kClassAt] = char(layers.classes->symbol(model, std::uint8_t(record[kClassAt])));
    }
    if (layout_.colour && layers.has_colour) code_colour(layers.colour, last + kColourAt, record + kColourAt);
    const std::size_t at = layout_.record_bytes() - layout_.extra_bytes;
    for (std::size_t i = 0; i < layout_.extra_bytes; ++i)
      if (layers.extra[i]) record[at + i] = code_byte(*layers.extra[i], bytes_[i], last[at + i], record[at + i]);
    return true;
  }

 private:
  template <class Coder>
  void code_position(Layers<Coder>& layers, const char* last, char* record) {
    constexpr std::uint32_t kOnlyReturn = 1;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto before = load<std::int32_t>(last + 4 * i);
      RunningMedian& median = medians_[i][time_changed_];
      const std::uint32_t context = i == 0 ? 0 : std::min(step_[0].bits(), 20u) & ~1u;
      const auto now = load<std::int32_t>(record + 4 * i);
      const std::int32_t step = step_[i].code(
          layers.plan, median.value(), std::int32_t(std::uint32_t(now) - std::uint32_t(before)), context | kOnlyReturn);
      median.add(step);
      store(std::int32_t(std::uint32_t(before) + std::uint32_t(step)), record + 4 * i);
    }
    const std::uint32_t context = std::min((step_[0].bits() + step_[1].bits()) / 2, 18u) & ~1u;
    const std::int32_t z = height_.code(layers.height, load<std::int32_t>(last + 8), load<std::int32_t>(record + 8),
                                        context | kOnlyReturn);
    store(z, record + 8);
  }

  template <class Coder>
  static char code_byte(Coder& coder, SymbolModel& model, int predicted, int byte) {
    return char(std::uint8_t(predicted + int(coder.symbol(model, std::uint8_t(byte - predicted)))));
  }

  // Green is predicted by the change of red, blue by that of both.
  template <class Coder>
  void code_colour(Coder& coder, const char* last_bytes, char* bytes) {
    std::array<std::uint16_t, 3> last, now;
    for (std::size_t i = 0; i < 3; ++i) {
      last[i] = load<std::uint16_t>(last_bytes + 2 * i);
      now[i] = load<std::uint16_t>(bytes + 2 * i);
    }
    const std::uint32_t changes = coder.symbol(changed_colours_, colour_changes(last, now));
    std::array<std::array<int, 2>, 3> halves{};
    const auto code_half = [&](std::uint32_t channel, std::uint32_t high, int change) {
      const std::uint32_t index = 2 * channel + high;
      const int before = byte_of(last[channel], int(high));
      int& half = halves[channel][high];
      half = before;
      if (changes >> index & 1)
        half = std::uint8_t(
            code_byte(coder, colours_[index], std::clamp(before + change, 0, 255), byte_of(now[channel], int(high))));
      return half - before;
    };
    const std::array<int, 2> red = {code_half(0, 0, 0), code_half(0, 1, 0)};
    if (changes & 64) {
      for (std::uint32_t high = 0; high < 2; ++high) {
        const int green = code_half(1, high, red[high]);
        code_half(2, high, (red[high] + green) / 2);
      }
    } else {
      halves[1] = halves[2] = halves[0];
    }
    for (std::size_t i = 0; i < 3; ++i) store(std::uint16_t(halves[i][0] | halves[i][1] << 8), bytes + 2 * i);
  }

  SymbolModel& class_model(std::size_t last_class) {
    if (!classes_[last_class]) classes_[last_class].emplace(256);
    return *classes_[last_class];
  }

  LazLayout layout_;
  std::vector<SymbolModel> changes_ = std::vector<SymbolModel>(8, SymbolModel(128));
  std::array<std::array<RunningMedian, 2>, 2> medians_;  // of the steps in x and y, time unchanged and changed
  std::array<NumberModel, 2> step_ = {NumberModel(2), NumberModel(22)};
  NumberModel height_{20};
  std::array<std::optional<SymbolModel>, 32> classes_;
  SymbolModel changed_colours_{128};
  std::vector<SymbolModel> colours_ = std::vector<SymbolModel>(6, SymbolModel(256));
  std::vector<SymbolModel> bytes_;
  bool time_changed_ = false;
};

// Bytes [at, at + size) are equal in all records.
bool constant(std::string_view records, std::size_t record_bytes, std::size_t at, std::size_t size) {
  for (std::size_t i = at; i < records.size(); i += record_bytes)
    if (records.compare(i, size, records.substr(at, size)) != 0) return false;
  return true;
}

Result<> damaged() { return fail(Errc::kBadFormat, "a compressed chunk is truncated or damaged"); }

// Cuts a chunk into its first record and the layers that are needed.
Result<Layers<ArithmeticDecoder>> layers_of(std::string_view chunk, std::uint64_t points, const LazLayout& layout) {
  Unpacker unpacker(chunk);
  unpacker.get_bytes(layout.record_bytes());
  if (unpacker.get<std::uint32_t>() != points) return tl::unexpected(damaged().error());
  std::vector<std::uint32_t> sizes(kPointLayers + (layout.colour ? 1 : 0) + (layout.infrared ? 1 : 0) +
                                   layout.extra_bytes);
  for (std::uint32_t& size : sizes) unpacker.get(size);
  std::vector<std::string_view> bytes;
  for (const std::uint32_t size : sizes) bytes.push_back(unpacker.get_bytes(size));
  if (!unpacker.ok()) return tl::unexpected(damaged().error());
  Layers<ArithmeticDecoder> layers;
  layers.plan = ArithmeticDecoder(bytes[0]);
  layers.height = ArithmeticDecoder(bytes[1]);
  if (!bytes[2].empty()) layers.classes.emplace(bytes[2]);
  layers.has_colour = layout.colour && !bytes[kPointLayers].empty();
  if (layers.has_colour) layers.colour = ArithmeticDecoder(bytes[kPointLayers]);
  layers.extra.resize(layout.extra_bytes);
  for (std::size_t i = 0; i < layout.extra_bytes; ++i) {
    const std::string_view of_byte = bytes[bytes.size() - layout.extra_bytes + i];
    if (!of_byte.empty()) layers.extra[i].emplace(of_byte);
  }
  return layers;
}

bool all_ok(const Layers<ArithmeticDecoder>& layers) {
  bool ok = layers.plan.ok() && layers.height.ok() && layers.colour.ok() && (!layers.classes || layers.classes->ok());
  for (const auto& extra : layers.extra) ok = ok && (!extra || extra->ok());
  return ok;
}

}  // namespace

std::string compress_laz_chunk(std::string_view records, const LazLayout& layout) {
  const std::size_t record_bytes = layout.record_bytes(), points = records.size() / record_bytes;
  COLLINEA_CHECK(points > 0 && points * record_bytes == records.size() && !layout.infrared);
  COLLINEA_CHECK(records[kReturnsAt] == 0x11 && records[kFlagsAt] == 0);
  COLLINEA_CHECK(constant(records, record_bytes, 12, 4) && constant(records, record_bytes, 17, 13));
  Layers<ArithmeticEncoder> layers;
  const std::size_t extra_at = record_bytes - layout.extra_bytes;
  if (!constant(records, record_bytes, kClassAt, 1)) layers.classes.emplace();
  layers.has_colour = layout.colour && !constant(records, record_bytes, kColourAt, 6);
  layers.extra.resize(layout.extra_bytes);
  for (std::size_t i = 0; i < layout.extra_bytes; ++i)
    if (!constant(records, record_bytes, extra_at + i, 1)) layers.extra[i].emplace();

  ChunkModels models(layout);
  std::string record;
  for (std::size_t i = 1; i < points; ++i) {
    record.assign(records, i * record_bytes, record_bytes);
    models.code(layers, records.data() + (i - 1) * record_bytes, record.data());
  }

  std::vector<std::string> bytes(kPointLayers);
  bytes[0] = layers.plan.finish();
  bytes[1] = layers.height.finish();
  if (layers.classes) bytes[2] = layers.classes->finish();
  if (layout.colour) bytes.push_back(layers.has_colour ? layers.colour.finish() : std::string());
  for (auto& extra : layers.extra) bytes.push_back(extra ? extra->finish() : std::string());
  Packer packer;
  packer.put_bytes(records.substr(0, record_bytes));
  packer.put(std::uint32_t(points));
  for (const std::string& layer : bytes) packer.put(std::uint32_t(layer.size()));
  for (const std::string& layer : bytes) packer.put_bytes(layer);
  return packer.bytes();
}

Result<std::string> expand_laz_chunk(std::string_view chunk, std::uint64_t points, const LazLayout& layout) {
  const std::size_t record_bytes = layout.record_bytes();
  COLLINEA_TRY(Layers<ArithmeticDecoder> layers, layers_of(chunk, points, layout));
  const int returns = std::uint8_t(chunk[kReturnsAt]), channel = std::uint8_t(chunk[kFlagsAt]) >> 4 & 3;
  if (returns != 0x11 || channel != 0)
    return fail(Errc::kUnsupported, "a cloud of a laser scanner with several returns or channels");
  ChunkModels models(layout);
  std::string records(chunk.substr(0, record_bytes));
  records.resize(points * record_bytes);
  for (char* last = records.data(); last + record_bytes < records.data() + records.size(); last += record_bytes) {
    char* record = last + record_bytes;
    std::copy(last, record, record);
    if (!models.code(layers, last, record))
      return fail(Errc::kUnsupported, "a cloud with several returns or channels, or a damaged chunk");
    if (!all_ok(layers)) return tl::unexpected(damaged().error());
  }
  return records;
}

}  // namespace collinea
