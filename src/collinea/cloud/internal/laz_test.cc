// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/internal/laz.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "collinea/base/file.h"
#include "collinea/base/packed.h"
#include "collinea/cloud/internal/laz_coder.h"
#include "collinea/cloud/las.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

TEST(ArithmeticCoder, AllKindsOfValuesComeBack) {
  SymbolModel few(2), many(256), back_few(2), back_many(256);
  BitModel bit, back_bit;
  ArithmeticEncoder encoder;
  Random random(1);
  std::vector<std::uint32_t> values;
  for (int i = 0; i < 20'000; ++i) {
    const int bits = 1 + int(random.below(32));
    const auto raw = std::uint32_t(random.bits()) >> (32 - bits);
    values.insert(values.end(), {random.below(20) == 0, random.below(4) ? 255u : random.below(256), std::uint32_t(bits),
                                 raw, random.below(3) == 0});
    const std::uint32_t* v = values.data() + values.size() - 5;
    encoder.symbol(few, v[0]);
    encoder.symbol(many, v[1]);
    encoder.raw(bits, raw);
    encoder.bit(bit, v[4]);
  }
  const std::string bytes = encoder.finish();
  ArithmeticDecoder decoder(bytes);
  for (std::size_t i = 0; i < values.size(); i += 5) {
    ASSERT_EQ(decoder.symbol(back_few), values[i]);
    ASSERT_EQ(decoder.symbol(back_many), values[i + 1]);
    ASSERT_EQ(decoder.raw(int(values[i + 2])), values[i + 3]);
    ASSERT_EQ(decoder.bit(back_bit), values[i + 4] != 0);
  }
  EXPECT_TRUE(decoder.ok());
}

// A symbol of probability p costs -log2 p bits; the model needs some to learn, the coder rounds.
TEST(ArithmeticCoder, FrequentSymbolsAreShort) {
  SymbolModel model(16);
  ArithmeticEncoder encoder;
  Random random(2);
  constexpr int kCount = 100'000;
  for (int i = 0; i < kCount; ++i) encoder.symbol(model, random.below(16) == 0 ? 3 : 9);
  const double entropy_bits = -(std::log2(1.0 / 16) / 16 + std::log2(15.0 / 16) * 15 / 16);
  const double bits = 8 * double(encoder.finish().size()) / kCount;
  EXPECT_GT(bits, 0.98 * entropy_bits);
  EXPECT_LT(bits, 1.03 * entropy_bits);
}

TEST(NumberModel, NumbersOfAllSizesComeBack) {
  std::vector<std::int32_t> numbers = {0, 1, -1, 2, INT32_MAX, INT32_MIN, -1, INT32_MAX, 0, INT32_MIN};
  Random random(3);
  for (int i = 0; i < 20'000; ++i) numbers.push_back(std::int32_t(std::uint32_t(random.bits()) >> random.below(32)));
  for (int k = 0; k < 31; ++k)  // the ends of all intervals
    for (const std::int32_t offset : {-1, 0, 1})
      for (const std::int32_t sign : {-1, 1}) numbers.push_back(sign * ((std::int32_t{1} << k) + offset));
  ArithmeticEncoder encoder;
  NumberModel model(2), back(2);
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    EXPECT_EQ(model.code(encoder, numbers[i - 1], numbers[i], i % 2), numbers[i]);
    encoder.raw(1, model.bits() & 1);
  }
  const std::string bytes = encoder.finish();
  ArithmeticDecoder decoder(bytes);
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    ASSERT_EQ(back.code(decoder, numbers[i - 1], 0, i % 2), numbers[i]) << i;
    ASSERT_EQ(decoder.raw(1), back.bits() & 1);
  }
  EXPECT_TRUE(decoder.ok());
}

// Records of a surface, some jumps; `varied`: class and every extra byte change.
std::string records(std::size_t count, const LazLayout& layout, bool varied) {
  Random random(5);
  Packer packer;
  std::int32_t x = 1000, y = -2'000'000'000;
  for (std::size_t i = 0; i < count; ++i) {
    x = std::int32_t(std::uint32_t(x) + (random.below(50) ? random.below(40) : std::uint32_t(random.bits())));
    y += std::int32_t(random.below(9)) - 4;
    packer.put(x);
    packer.put(y);
    packer.put(std::int32_t(random.below(300)) - 150);
    packer.put(std::uint16_t{7});
    packer.put(std::uint8_t{0x11});
    packer.put(std::uint8_t{0});
    packer.put(std::uint8_t(varied ? random.below(256) : 2));
    packer.put_text("udsource_time", 13);
    const auto grey = std::uint16_t(random.bits());
    if (layout.colour)
      for (int c = 0; c < 3; ++c)
        packer.put(varied && i % 3 ? std::uint16_t(random.bits()) : varied ? grey : std::uint16_t{9});
    for (std::size_t e = 0; e < layout.extra_bytes; ++e) packer.put(std::uint8_t(varied && e != 1 ? random.bits() : 3));
  }
  return packer.bytes();
}

TEST(LazChunk, ComesBackBitForBit) {
  for (const bool varied : {false, true})
    for (const bool colour : {false, true})
      for (const std::size_t extra : {0, 5})
        for (const std::size_t count : {1, 2, 3000}) {
          const LazLayout layout{colour, false, extra};
          const std::string whole = records(count, layout, varied);
          const auto back = expand_laz_chunk(compress_laz_chunk(whole, layout), count, layout);
          ASSERT_TRUE(back) << back.error().message;
          ASSERT_TRUE(*back == whole) << varied << colour << extra << count;
        }
}

TEST(LazChunk, WhatNeverChangesTakesNoBytes) {
  const LazLayout layout{true, false, 5};
  const std::string chunk = compress_laz_chunk(records(1000, layout, false), layout);
  Unpacker sizes(std::string_view(chunk).substr(layout.record_bytes() + 4));
  for (int i = 0; i < 15; ++i) EXPECT_EQ(sizes.get<std::uint32_t>() == 0, i > 1) << i;
}

TEST(LazChunk, SeveralReturnsAreRefused) {
  const LazLayout layout{};
  std::string chunk = compress_laz_chunk(records(10, layout, true), layout);
  chunk[14] = 0x21;
  const auto back = expand_laz_chunk(chunk, 10, layout);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().code, Errc::kUnsupported);
}

TEST(LazChunk, NoBytesCrashIt) {
  const LazLayout layout{true, false, 5};
  const std::string whole = compress_laz_chunk(records(200, layout, true), layout);
  int refused = 0;
  for (std::uint64_t trial = 0; trial < 600; ++trial) {
    Random random(6, trial);
    std::string bytes = whole;
    for (int i = 0; i < 4; ++i)
      bytes[random.below(trial % 2 ? 120 : std::uint32_t(bytes.size()))] = char(random.bits());
    if (trial % 3 == 0) bytes.resize(random.below(std::uint32_t(bytes.size())));
    refused += !expand_laz_chunk(bytes, 200, layout);
  }
  EXPECT_GT(refused, 300);  // the rest are points at wrong positions: a chunk has no checksum
}

TEST(LazChunk, EveryTruncationIsFound) {
  const LazLayout layout{true, false, 5};
  const std::string whole = compress_laz_chunk(records(60, layout, true), layout);
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_FALSE(expand_laz_chunk(std::string_view(whole).substr(0, size), 60, layout)) << size;
}

class LazFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("collinea_laz_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const char* name, std::size_t count, bool compressed, int threads = 1) const {
    LasWriter::Options options;
    options.lowest.setConstant(-500);
    options.highest.setConstant(500);
    options.wkt = "PROJCS[\"any\"]";
    options.form = compressed ? LasForm::kLaz : LasForm::kLas;
    options.run.threads = threads;
    auto writer = LasWriter::create(folder_ / name, options);
    ASSERT_TRUE(writer) << writer.error().message;
    Random random(7);
    std::vector<CloudPoint> points(count);
    for (std::size_t i = 0; i < count; ++i) {
      points[i].position = {0.001 * double(i), random.normal(), 0.1 * random.normal()};
      for (auto& channel : points[i].colour) channel = std::uint8_t(100 + random.below(20));
      points[i].sigma_m = float(0.01 * random.uniform());
      points[i].images = std::uint8_t(3 + random.below(4));
    }
    for (std::size_t at = 0; at < count; at += 7777)
      ASSERT_TRUE(writer->write(std::span(points).subspan(at, std::min<std::size_t>(7777, count - at))));
    const auto finished = writer->finish();
    ASSERT_TRUE(finished) << finished.error().message;
  }
  [[nodiscard]] std::string bytes_of(const char* name) const { return *read_file(folder_ / name); }
  fs::path folder_;
};

TEST_F(LazFile, HoldsThePointsOfTheLas) {
  constexpr std::size_t kCount = 120'001;  // three chunks
  write("a.las", kCount, false);
  write("a.laz", kCount, true);
  auto las = LasReader::open(folder_ / "a.las"), laz = LasReader::open(folder_ / "a.laz");
  ASSERT_TRUE(las && laz) << (laz ? las : laz).error().message;
  EXPECT_EQ(laz->header().points, kCount);
  EXPECT_EQ(laz->header().point_format, 7);
  EXPECT_EQ(laz->header().wkt, las->header().wkt);
  EXPECT_EQ(laz->header().highest, las->header().highest);
  EXPECT_EQ(laz->header().extra_names, las->header().extra_names);
  std::size_t read = 0;
  while (true) {
    const auto a = las->read(33'333), b = laz->read(33'333);
    ASSERT_TRUE(a && b) << (b ? a : b).error().message;
    ASSERT_EQ(a->size(), b->size());
    if (a->empty()) break;
    for (std::size_t i = 0; i < a->size(); ++i) {
      ASSERT_EQ((*a)[i].position, (*b)[i].position);
      ASSERT_EQ((*a)[i].colour, (*b)[i].colour);
      ASSERT_EQ((*a)[i].sigma_m, (*b)[i].sigma_m);
      ASSERT_EQ((*a)[i].images, (*b)[i].images);
    }
    read += a->size();
  }
  EXPECT_EQ(read, kCount);
  EXPECT_LT(2 * bytes_of("a.laz").size(), bytes_of("a.las").size());
}

TEST_F(LazFile, DoesNotDependOnTheNumberOfThreads) {
  write("one.laz", 160'000, true, 1);
  write("three.laz", 160'000, true, 3);
  EXPECT_TRUE(bytes_of("one.laz") == bytes_of("three.laz"));
}

TEST_F(LazFile, MayBeEmpty) {
  write("a.laz", 0, true);
  auto reader = LasReader::open(folder_ / "a.laz");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(reader->read(10)->empty());
}

TEST_F(LazFile, AStoppedRunLeavesNoFile) {
  std::stop_source stop;
  LasWriter::Options options;
  options.form = LasForm::kLaz;
  options.run.stop = stop.get_token();
  auto writer = LasWriter::create(folder_ / "a.laz", options);
  ASSERT_TRUE(writer->write(std::vector<CloudPoint>(10)));
  stop.request_stop();
  const auto finished = writer->finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, Errc::kCancelled);
  EXPECT_FALSE(fs::exists(folder_ / "a.laz"));
}

TEST_F(LazFile, TruncatedAndDamagedFilesAreRefusedInWords) {
  write("a.laz", 500, true);
  const std::string whole = bytes_of("a.laz");
  const auto refused = [&](const std::string& bytes) {
    EXPECT_TRUE(write_file(folder_ / "b.laz", bytes));
    auto reader = LasReader::open(folder_ / "b.laz");
    if (!reader) return !reader.error().message.empty();
    const auto points = reader->read(1'000'000);
    return !points && !points.error().message.empty();
  };
  ASSERT_FALSE(refused(whole));
  for (std::size_t i = 0; i < 150; ++i) EXPECT_TRUE(refused(whole.substr(0, whole.size() * i / 150))) << i;
  int found = 0;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    Random random(8, trial);
    std::string bytes = whole;
    for (int i = 0; i < 5; ++i)
      bytes[random.below(trial % 2 ? 900 : std::uint32_t(bytes.size()))] = char(random.bits());
    found += refused(bytes);
  }
  EXPECT_GT(found, 150);
}

}  // namespace
}  // namespace collinea
