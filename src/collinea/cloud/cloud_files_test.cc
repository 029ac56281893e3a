// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "collinea/base/packed.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/cloud/ply_reader.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

class CloudFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("collinea_cloud_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string bytes_of(const std::string& name) const {
    std::ifstream input(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(input), {}};
  }
  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  fs::path folder_;
};

const Eigen::Vector3d kSite(500'123.25, 4'600'456.5, 101.125);

std::vector<CloudPoint> cloud(std::size_t count) {
  Random random(4);
  std::vector<CloudPoint> points(count);
  for (CloudPoint& point : points) {
    point.position = kSite + 50 * Eigen::Vector3d(random.normal(), random.normal(), 0.1 * random.normal());
    point.normal = Eigen::Vector3f(0, 0.6f, 0.8f);
    for (auto& channel : point.colour) channel = std::uint8_t(random.bits());
    point.sigma_m = float(random.uniform());
    point.images = std::uint8_t(2 + random.below(9));
    point.classification = 2;
  }
  return points;
}

LasWriter::Options options_of_site() {
  LasWriter::Options options;
  options.lowest = kSite.array() - 300;
  options.highest = kSite.array() + 300;
  options.wkt = "PROJCS[\"any\"]";
  return options;
}

void write_las(const fs::path& path, const std::vector<CloudPoint>& points, const LasWriter::Options& options) {
  auto writer = LasWriter::create(path, options);
  ASSERT_TRUE(writer) << writer.error().message;
  const std::span<const CloudPoint> all(points);
  ASSERT_TRUE(writer->write(all.first(points.size() / 3)));
  ASSERT_TRUE(writer->write(all.subspan(points.size() / 3)));
  EXPECT_FALSE(fs::exists(path));  // not before it is complete
  const auto finished = writer->finish();
  ASSERT_TRUE(finished) << finished.error().message;
}

TEST_F(CloudFiles, LasComesBackWithinItsResolution) {
  const auto points = cloud(20'000);
  write_las(folder_ / "a.las", points, options_of_site());
  auto reader = LasReader::open(folder_ / "a.las");
  ASSERT_TRUE(reader) << reader.error().message;
  const LasHeader& header = reader->header();
  EXPECT_EQ(header.points, points.size());
  EXPECT_EQ(header.point_format, 7);
  EXPECT_EQ(header.wkt, "PROJCS[\"any\"]");
  EXPECT_EQ(header.extra_names, (std::vector<std::string>{"sigma_m", "images"}));
  EXPECT_EQ(header.scale.x(), 0.0001);
  const auto first = reader->read(7), rest = reader->read(1'000'000), none = reader->read(10);
  ASSERT_TRUE(first && rest && none);
  ASSERT_EQ(first->size(), 7u);
  ASSERT_EQ(rest->size(), points.size() - 7);
  EXPECT_TRUE(none->empty());
  Eigen::Vector3d lowest = points[0].position, highest = lowest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const CloudPoint& back = i < 7 ? (*first)[i] : (*rest)[i - 7];
    ASSERT_LT((back.position - points[i].position).cwiseAbs().maxCoeff(), 0.5001e-4);
    ASSERT_EQ(back.colour, points[i].colour);
    ASSERT_NEAR(back.sigma_m, points[i].sigma_m, 0.004 * points[i].sigma_m);
    ASSERT_EQ(back.images, points[i].images);
    ASSERT_EQ(back.classification, 2);
    lowest = lowest.cwiseMin(back.position);
    highest = highest.cwiseMax(back.position);
  }
  EXPECT_EQ(header.lowest, lowest);
  EXPECT_EQ(header.highest, highest);
}

// What was read from a file and is written like it is the same file, though the bounds stated are others.
TEST_F(CloudFiles, LasWrittenLikeAnotherIsTheSame) {
  for (const LasForm form : {LasForm::kLas, LasForm::kLaz, LasForm::kCopc}) {
    LasWriter::Options options = options_of_site();
    options.form = form;
    write_las(folder_ / "a.las", cloud(5'000), options);
    auto reader = LasReader::open(folder_ / "a.las");
    ASSERT_TRUE(reader) << reader.error().message;
    options.like = reader->header();
    options.lowest = options.highest = Eigen::Vector3d(3, 1, 4);
    const auto points = reader->read(5'000);
    ASSERT_TRUE(points);
    write_las(folder_ / "b.las", *points, options);
    EXPECT_EQ(bytes_of("a.las"), bytes_of("b.las"));
    fs::remove(folder_ / "b.las");
    fs::remove(folder_ / "a.las");
  }
}

// Offsets and values from the ASPRS LAS 1.4 R15 specification, tables 3 and 24.
TEST_F(CloudFiles, LasBytesLieWhereTheSpecificationPutsThem) {
  auto points = cloud(3);
  points[0].position = kSite;
  write_las(folder_ / "a.las", points, options_of_site());
  const std::string bytes = bytes_of("a.las");
  const auto u8 = [&](std::size_t at) { return int(std::uint8_t(bytes.at(at))); };
  const auto u16 = [&](std::size_t at) { return Unpacker(std::string_view(bytes).substr(at)).get<std::uint16_t>(); };
  const auto u32 = [&](std::size_t at) { return Unpacker(std::string_view(bytes).substr(at)).get<std::uint32_t>(); };
  const auto u64 = [&](std::size_t at) { return Unpacker(std::string_view(bytes).substr(at)).get<std::uint64_t>(); };
  const auto f64 = [&](std::size_t at) { return Unpacker(std::string_view(bytes).substr(at)).get<double>(); };
  EXPECT_EQ(bytes.substr(0, 4), "LASF");
  EXPECT_EQ(u16(6), 16);  // global encoding: WKT
  EXPECT_EQ(u8(24), 1);
  EXPECT_EQ(u8(25), 4);
  EXPECT_EQ(u16(94), 375);  // header size
  EXPECT_EQ(u32(100), 2u);  // variable length records
  EXPECT_EQ(u8(104), 7);
  EXPECT_EQ(u16(105), 41);  // 36 + float + byte
  EXPECT_EQ(u32(107), 0u);  // legacy count
  EXPECT_EQ(f64(131), 0.0001);
  EXPECT_EQ(f64(155), std::round(kSite.x()));
  EXPECT_EQ(u64(247), 3u);  // points
  EXPECT_EQ(u64(255), 3u);  // first returns
  EXPECT_EQ(bytes.substr(375 + 2, 15), "LASF_Projection");
  EXPECT_EQ(u16(375 + 18), 2112);
  const std::size_t at = u32(96);
  EXPECT_EQ(bytes.size(), at + 3 * 41);
  EXPECT_EQ(std::int32_t(u32(at)), 2500);  // 0.25 m from the offset
  EXPECT_EQ(u8(at + 14), 0x11);
  EXPECT_EQ(u8(at + 16), 2);
  EXPECT_EQ(u16(at + 30), points[0].colour[0] * 256);
}

TEST_F(CloudFiles, AnEmptyLasIsAValidFile) {
  write_las(folder_ / "a.las", {}, {});
  auto reader = LasReader::open(folder_ / "a.las");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->header().points, 0u);
  EXPECT_EQ(reader->header().lowest, Eigen::Vector3d::Zero());
  EXPECT_TRUE(reader->read(10)->empty());
}

TEST_F(CloudFiles, AVeryLongWktGoesBehindThePoints) {
  auto options = options_of_site();
  options.wkt = "PROJCS[\"" + std::string(70'000, 'x') + "\"]";
  options.extra_bytes = false;
  write_las(folder_ / "a.las", cloud(10), options);
  auto reader = LasReader::open(folder_ / "a.las");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->header().wkt, options.wkt);
  EXPECT_EQ(reader->read(100)->size(), 10u);
}

TEST_F(CloudFiles, TheResolutionFollowsTheExtent) {
  for (const auto& [extent, scale] : {std::pair{500e3, 0.001}, std::pair{5e6, 0.01}}) {
    LasWriter::Options options;
    options.highest.setConstant(extent);
    const auto writer = LasWriter::create(folder_ / "a.las", options);
    EXPECT_EQ(writer->header().scale.x(), scale);
  }
  EXPECT_TRUE(fs::is_empty(folder_));  // what is not finished leaves nothing
}

TEST_F(CloudFiles, PointsThatDoNotFitAreRefused) {
  auto writer = LasWriter::create(folder_ / "a.las", options_of_site());
  CloudPoint far;
  far.position = kSite.array() + 1e6;
  EXPECT_FALSE(writer->write({&far, 1}));
  far.position.setConstant(std::nan(""));
  EXPECT_FALSE(writer->write({&far, 1}));
}

// Formats of older versions, written here by hand: 1.2 with point formats 0 to 3.
TEST_F(CloudFiles, OldLasIsRead) {
  for (const auto& [format, length] : {std::pair{0, 20}, std::pair{1, 28}, std::pair{2, 26}, std::pair{3, 34}}) {
    Packer h;
    h.put_text("LASF", 24);
    h.put(std::uint8_t{1});
    h.put(std::uint8_t{2});
    h.put_text("", 68);
    h.put(std::uint16_t{227});
    h.put(std::uint32_t{227});
    h.put(std::uint32_t{0});
    h.put(std::uint8_t(format));
    h.put(std::uint16_t(length));
    h.put(std::uint32_t{1});
    h.put_text("", 20);
    for (const double value : {0.01, 0.01, 0.01, 100.0, 200.0, 300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}) h.put(value);
    ASSERT_EQ(h.size(), 227u);
    for (const std::int32_t cell : {150, -250, 350}) h.put(cell);
    h.put(std::uint16_t{0});
    h.put(std::uint8_t{0});
    h.put(std::uint8_t{0x80 | 6});  // withheld bit and class 6
    h.put_text("", 4);
    if (format % 2) h.put(0.0);
    if (format >= 2)
      for (const int channel : {10, 20, 255}) h.put(std::uint16_t(channel * 257));
    put("old.las", h.bytes());
    auto reader = LasReader::open(folder_ / "old.las");
    ASSERT_TRUE(reader) << reader.error().message;
    const auto points = reader->read(10);
    ASSERT_EQ(points->size(), 1u);
    EXPECT_LT((points->at(0).position - Eigen::Vector3d(101.5, 197.5, 303.5)).norm(), 1e-9);
    EXPECT_EQ(points->at(0).classification, 6);
    if (format >= 2) {
      EXPECT_EQ(points->at(0).colour, (std::array<std::uint8_t, 3>{10, 20, 255}));
    }
  }
}

TEST_F(CloudFiles, NoBytesCrashTheLasReader) {
  write_las(folder_ / "a.las", cloud(20), options_of_site());
  const std::string whole = bytes_of("a.las");
  int refused = 0;
  for (std::uint64_t trial = 0; trial < 150; ++trial) {
    Random random(9, trial);
    std::string bytes = whole;
    for (int i = 0; i < 5; ++i)
      bytes[random.below(trial % 2 ? 400 : std::uint32_t(bytes.size()))] = char(random.bits());
    if (trial % 3 == 0) bytes.resize(random.below(std::uint32_t(bytes.size())));
    put("b.las", bytes);
    auto reader = LasReader::open(folder_ / "b.las");
    if (!reader || !reader->read(1000)) ++refused;
  }
  EXPECT_GT(refused, 50);
  EXPECT_LT(refused, 150);
}

TEST_F(CloudFiles, CompressionOfOldVersionsIsNamedAsSuch) {
  write_las(folder_ / "a.las", cloud(2), options_of_site());
  std::string bytes = bytes_of("a.las");
  bytes[104] = char(0x83);
  put("a.laz", bytes);
  const auto reader = LasReader::open(folder_ / "a.laz");
  ASSERT_FALSE(reader);
  EXPECT_NE(reader.error().message.find("LAZ"), std::string::npos);
}

TEST_F(CloudFiles, PlyComesBackExactly) {
  const auto points = cloud(9'000);
  auto writer = PlyWriter::create(folder_ / "a.ply", "EPSG:32633\nsecond line");
  ASSERT_TRUE(writer);
  writer->write(std::span(points).first(11));
  writer->write(std::span(points).subspan(11));
  ASSERT_TRUE(writer->finish());
  const auto read = read_ply(folder_ / "a.ply");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ((*read)[i].position, points[i].position);
    ASSERT_EQ((*read)[i].normal, points[i].normal);
    ASSERT_EQ((*read)[i].colour, points[i].colour);
    ASSERT_EQ((*read)[i].sigma_m, points[i].sigma_m);
    ASSERT_EQ((*read)[i].images, points[i].images);
    ASSERT_EQ((*read)[i].classification, points[i].classification);
  }
}

TEST_F(CloudFiles, PlyComesInPiecesToo) {
  const auto points = cloud(5'000);
  auto writer = PlyWriter::create(folder_ / "a.ply", "frame");
  ASSERT_TRUE(writer);
  writer->write(points);
  ASSERT_TRUE(writer->finish());
  auto reader = PlyReader::open(folder_ / "a.ply");
  ASSERT_TRUE(reader) << reader.error().message;
  std::vector<CloudPoint> read;
  for (;;) {
    const auto piece = reader->read(1'700);
    ASSERT_TRUE(piece);
    if (piece->empty()) break;
    EXPECT_LE(piece->size(), 1'700u);
    read.insert(read.end(), piece->begin(), piece->end());
  }
  ASSERT_EQ(read.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(read[i].position, points[i].position);
    ASSERT_EQ(read[i].normal, points[i].normal);
    ASSERT_EQ(read[i].colour, points[i].colour);
    ASSERT_EQ(read[i].sigma_m, points[i].sigma_m);
    ASSERT_EQ(read[i].images, points[i].images);
    ASSERT_EQ(read[i].classification, points[i].classification);
  }
  EXPECT_FALSE(PlyReader::open(folder_ / "none.ply"));
  std::string bytes = bytes_of("a.ply");
  put("cut.ply", bytes.substr(0, bytes.size() - 20));
  auto cut = PlyReader::open(folder_ / "cut.ply");
  ASSERT_TRUE(cut);
  EXPECT_FALSE(cut->read(5'000));
  put("other.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n");
  EXPECT_FALSE(PlyReader::open(folder_ / "other.ply"));
}

TEST(Ply, TextAndBigEndianAreRead) {
  const auto text = parse_ply(
      "ply\nformat ascii 1.0\ncomment c\nelement vertex 2\nproperty float x\nproperty float y\nproperty int other\n"
      "property float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "1 2 9 3 200\n4 5 9 6 7\n3 0 1 1\n");
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(text->at(1).position, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(text->at(0).colour[0], 200);
  const std::string big =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty short y\nend_header\n" +
      std::string("\x3f\x80\0\0\x01\x02", 6);
  const auto points = parse_ply(big);
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_EQ(points->at(0).position, Eigen::Vector3d(1, 258, 0));
}

TEST(Ply, NoBytesCrashTheReader) {
  const std::string whole =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double x\nproperty uchar red\nend_header\n"
      "012345678012345678";
  ASSERT_TRUE(parse_ply(whole));
  int refused = 0;
  for (std::uint64_t trial = 0; trial < 3000; ++trial) {
    Random random(2, trial);
    std::string bytes = whole;
    for (int i = 0; i < 3; ++i) bytes[random.below(std::uint32_t(bytes.size()))] = char(random.bits());
    if (trial % 3 == 0) bytes.resize(random.below(std::uint32_t(bytes.size())));
    refused += !parse_ply(bytes);
  }
  EXPECT_GT(refused, 1000);
  EXPECT_FALSE(
      parse_ply("ply\nformat ascii 1.0\nelement vertex 9223372036854775807\nproperty float x\nend_header\n1\n"));
}

}  // namespace
}  // namespace collinea
