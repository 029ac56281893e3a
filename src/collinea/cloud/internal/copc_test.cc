// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/internal/copc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "collinea/base/file.h"
#include "collinea/base/packed.h"
#include "collinea/cloud/las.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr LazLayout kLayout{true, false, 5};
constexpr std::size_t kInfoAt = 375 + 54;

struct Point {
  std::array<std::int32_t, 3> position;
  std::uint16_t red;
};

// Records of a rolling surface, `count` points of it at random.
std::vector<Point> surface(std::size_t count, double side = 1e6) {
  Random random(11);
  std::vector<Point> points(count);
  for (Point& p : points) {
    const double x = side * random.uniform(), y = side * random.uniform();
    p = {{std::int32_t(x) - 1000, std::int32_t(y) + 2000, std::int32_t(0.05 * side * std::sin(6 * x / side))},
         std::uint16_t(random.bits())};
  }
  return points;
}

std::string records_of(const std::vector<Point>& points) {
  Packer packer;
  for (const Point& p : points) {
    for (const std::int32_t along : p.position) packer.put(along);
    packer.put(std::uint16_t{0});
    packer.put(std::uint8_t{0x11});
    packer.put_text("", 15);
    for (int c = 0; c < 3; ++c) packer.put(p.red);
    packer.put(0.25f);
    packer.put(std::uint8_t{3});
  }
  return packer.bytes();
}

class Copc : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("collinea_copc_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // The nodes alone, from byte 0: chunks, table; then info and hierarchy.
  std::string sorted(const std::string& records, const CopcSizes& sizes, int threads = 1) const {
    collinea::Run run;
    run.threads = threads;
    auto stream = CopcStream::create(folder_ / "a", kLayout, run, sizes);
    auto file = OutputFile::create(folder_ / "a");
    EXPECT_TRUE(stream && file);
    for (std::size_t at = 0; at < records.size(); at += 41 * 7777)
      EXPECT_TRUE(stream->add(std::string_view(records).substr(at, 41 * 7777)));
    const auto finished = stream->finish(*file, Eigen::Vector3d::Constant(0.001), {10, 20, 30});
    EXPECT_TRUE(finished) << finished.error().message;
    info_ = stream->info(123);
    hierarchy_ = stream->hierarchy();
    EXPECT_TRUE(file->finish());
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);  // nothing is left of the sorting
    return *read_file(folder_ / "a") + info_ + hierarchy_;
  }

  struct Node {
    int level;
    std::array<int, 3> key;
    std::string records;
  };
  static std::vector<Node> nodes_of(const std::string& file, const std::string& hierarchy) {
    std::vector<Node> nodes;
    Unpacker h(hierarchy);
    while (h.left() > 0) {
      Node node;
      h.get(node.level);
      for (int& along : node.key) h.get(along);
      const auto at = h.get<std::uint64_t>();
      const auto bytes = h.get<std::int32_t>(), points = h.get<std::int32_t>();
      if (points > 0) {
        const auto records =
            expand_laz_chunk(std::string_view(file).substr(at, std::size_t(bytes)), std::uint64_t(points), kLayout);
        EXPECT_TRUE(records) << records.error().message;
        if (records) node.records = *records;
      }
      nodes.push_back(std::move(node));
    }
    return nodes;
  }
  static std::multiset<std::string> set_of(std::string_view records) {
    std::multiset<std::string> set;
    for (std::size_t at = 0; at < records.size(); at += 41) set.emplace(records.substr(at, 41));
    return set;
  }

  fs::path folder_;
  mutable std::string info_, hierarchy_;
};

// Every point in one node, within its cube; of a divided node at most one in a cell of the grid; no node without its
// parent; a node is divided only when it must be.
TEST_F(Copc, IsAnOctreeOfEvenSamplesWithoutLoss) {
  const std::string records = records_of(surface(150'000));
  const CopcSizes sizes{5000, 40'000};
  const std::string file = sorted(records, sizes);
  Unpacker info(info_);
  Eigen::Vector3d centre;
  for (int i = 0; i < 3; ++i) info.get(centre[i]);
  const double half = info.get<double>(), spacing = info.get<double>();
  EXPECT_EQ(spacing, 2 * half / 128);
  EXPECT_EQ(info.get<std::uint64_t>(), 123u);
  EXPECT_EQ(info.get<std::uint64_t>(), hierarchy_.size());
  EXPECT_EQ(info_.size(), 160u);
  const Eigen::Vector3d corner = centre.array() - half;
  const std::vector<Node> nodes = nodes_of(file, hierarchy_);
  std::set<std::array<int, 4>> keys, divided;
  for (const Node& node : nodes) {
    if (node.level > 0) divided.insert({node.level - 1, node.key[0] / 2, node.key[1] / 2, node.key[2] / 2});
    EXPECT_TRUE(keys.insert({node.level, node.key[0], node.key[1], node.key[2]}).second);
  }
  for (const auto& key : divided) EXPECT_TRUE(keys.contains(key));
  EXPECT_GT(divided.size(), 4u);
  std::string all;
  for (const Node& node : nodes) {
    all += node.records;
    const double side = std::ldexp(2 * half, -node.level);
    const bool is_divided = divided.contains({node.level, node.key[0], node.key[1], node.key[2]});
    EXPECT_LE(node.records.size(), 41 * (is_divided ? 128u * 128 * 128 : sizes.leaf_points));
    std::set<std::array<int, 3>> cells;
    for (std::size_t at = 0; at < node.records.size(); at += 41) {
      Unpacker r(std::string_view(node.records).substr(at, 12));
      std::array<int, 3> cell;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = Eigen::Index(i);
        const double position = 10 * (axis + 1) + 0.001 * r.get<std::int32_t>();
        const double inside = (position - corner[axis]) / side - node.key[i];
        EXPECT_GT(inside, -1e-9);
        EXPECT_LT(inside, 1 + 1e-9);
        cell[i] = int(128 * inside);
      }
      EXPECT_TRUE(cells.insert(cell).second || !is_divided);
    }
  }
  EXPECT_EQ(set_of(all), set_of(records));
}

// What a coarse node shows: where there are points, a cell of its grid is not empty.
TEST_F(Copc, TheRootSeesEveryCellThatHoldsPoints) {
  const std::string records = records_of(surface(60'000));
  const std::string file = sorted(records, {5000, 100'000});
  const std::vector<Node> nodes = nodes_of(file, hierarchy_);
  ASSERT_EQ(nodes[0].level, 0);
  Unpacker info(info_);
  Eigen::Vector3d corner;
  for (int i = 0; i < 3; ++i) info.get(corner[i]);
  const double half = info.get<double>();
  corner.array() -= half;
  const auto cells_of = [&](std::string_view bytes) {
    std::set<std::array<int, 3>> cells;
    for (std::size_t at = 0; at < bytes.size(); at += 41) {
      Unpacker r(bytes.substr(at, 12));
      std::array<int, 3> cell;
      for (std::size_t i = 0; i < 3; ++i)
        cell[i] = int(64 / half * (10 * double(i + 1) + 0.001 * r.get<std::int32_t>() - corner[Eigen::Index(i)]));
      cells.insert(cell);
    }
    return cells;
  };
  EXPECT_EQ(cells_of(nodes[0].records), cells_of(records));
  EXPECT_EQ(cells_of(nodes[0].records).size(), nodes[0].records.size() / 41);
}

TEST_F(Copc, DependsNeitherOnThreadsNorOnWhatIsSortedInMemory) {
  const std::string records = records_of(surface(80'000));
  const std::string once = sorted(records, {3000, 1'000'000});
  EXPECT_TRUE(sorted(records, {3000, 1'000'000}, 3) == once);
  EXPECT_TRUE(sorted(records, {3000, 10'000}, 1) == once);
  EXPECT_TRUE(sorted(records, {3000, 3000}, 2) == once);
}

// The points of a node follow those of its ancestors and keep their order, so that sorting again changes nothing: what
// gives the points classes leaves the tree as it is.
TEST_F(Copc, SortingAgainChangesNothing) {
  std::vector<Point> points = surface(50'000);
  for (std::size_t i = 1; i < points.size(); i += 2) points[i].position = points[i - 1].position;  // ties
  const std::string once = sorted(records_of(points), {3000, 20'000});
  std::string again;
  for (const Node& node : nodes_of(once, hierarchy_)) again += node.records;
  EXPECT_TRUE(sorted(again, {3000, 20'000}) == once);
}

TEST_F(Copc, NoPointsHaveARootWithoutAny) {
  const std::string file = sorted("", {});
  const std::vector<Node> nodes = nodes_of(file, hierarchy_);
  ASSERT_EQ(nodes.size(), 1u);
  EXPECT_TRUE(nodes[0].records.empty());
  EXPECT_EQ(hierarchy_, std::string(32, '\0'));
}

TEST_F(Copc, OnePointIsARoot) {
  const std::string records = records_of(surface(1));
  const std::vector<Node> nodes = nodes_of(sorted(records, {}), hierarchy_);
  ASSERT_EQ(nodes.size(), 1u);
  EXPECT_EQ(nodes[0].records, records);
}

// Points at one position cannot be divided by position: nodes below one another hold so many each. Beyond the last
// level that a key can name the rest stays together.
TEST_F(Copc, EqualPointsAreStillCutIntoNodes) {
  for (const std::uint64_t branch : {100u, 100'000u}) {
    std::vector<Point> points(4000, {{5, -7, 9}, 1});
    const std::vector<Node> nodes = nodes_of(sorted(records_of(points), {100, branch}), hierarchy_);
    ASSERT_EQ(nodes.size(), 31u);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      EXPECT_EQ(nodes[i].level, int(i));
      EXPECT_EQ(nodes[i].records.size() / 41, i < 30 ? 100u : 1000u);
    }
  }
}

// As far apart as coordinates of 32 bits can be, in two heaps with twins.
TEST_F(Copc, HugeExtentsLoseNothing) {
  std::vector<Point> points = surface(3000, 1000);
  for (std::size_t i = 0; i < 1000; ++i)
    for (std::size_t k = 0; k < 3; ++k) points[i].position[k] = INT32_MAX - std::int32_t(i % 10);
  points.push_back({{INT32_MIN, INT32_MIN, INT32_MIN}, 7});
  const std::string records = records_of(points);
  std::string all;
  const std::vector<Node> nodes = nodes_of(sorted(records, {50, 500}), hierarchy_);
  for (const Node& node : nodes) {
    all += node.records;
    for (const int along : node.key) EXPECT_GE(along, 0);
  }
  EXPECT_EQ(set_of(all), set_of(records));
}

// The whole file, as LAS readers see it.
TEST_F(Copc, IsALazFileWithItsInfoFirst) {
  for (const std::size_t wkt_bytes : {10u, 70'000u}) {
    LasWriter::Options options;
    options.lowest = {500'000, 5'000'000, 0};
    options.highest = {500'100, 5'000'100, 40};
    options.wkt = "PROJCS[\"" + std::string(wkt_bytes, 'x') + "\"]";
    options.form = LasForm::kCopc;
    options.run.threads = 2;
    auto writer = LasWriter::create(folder_ / "a.copc.laz", options);
    ASSERT_TRUE(writer) << writer.error().message;
    Random random(1);
    std::vector<CloudPoint> points(130'000);
    for (CloudPoint& p : points) {
      p.position = Eigen::Vector3d(500'000 + 100 * random.uniform(), 5'000'000 + 100 * random.uniform(), 0);
      p.position.z() = 20 + std::sin(0.1 * p.position.x());
      p.colour = {std::uint8_t(random.below(256)), 2, 3};
      p.sigma_m = 0.5f;
      p.images = 4;
      p.classification = std::uint8_t(random.below(3));
    }
    ASSERT_TRUE(writer->write(points));
    ASSERT_TRUE(writer->finish());
    const std::string bytes = *read_file(folder_ / "a.copc.laz");
    EXPECT_EQ(bytes.substr(377, 4), "copc");
    EXPECT_EQ(bytes.substr(393, 2), std::string("\1\0", 2));
    Unpacker info(std::string_view(bytes).substr(kInfoAt + 40));
    const auto hierarchy_at = info.get<std::uint64_t>(), hierarchy_bytes = info.get<std::uint64_t>();
    ASSERT_EQ(hierarchy_bytes % 32, 0u);
    const auto nodes = nodes_of(bytes, bytes.substr(hierarchy_at, hierarchy_bytes));
    EXPECT_GT(nodes.size(), 4u);
    std::size_t in_nodes = 0;
    for (const Node& node : nodes) in_nodes += node.records.size() / 41;
    EXPECT_EQ(in_nodes, points.size());

    auto reader = LasReader::open(folder_ / "a.copc.laz");
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_EQ(reader->header().wkt, options.wkt);
    EXPECT_EQ(reader->header().points, points.size());
    EXPECT_EQ(reader->header().extra_names, (std::vector<std::string>{"sigma_m", "images"}));
    auto back = reader->read(1'000'000);
    ASSERT_TRUE(back) << back.error().message;
    const auto before = [](const CloudPoint& a, const CloudPoint& b) {
      return std::tie(a.position.x(), a.position.y()) < std::tie(b.position.x(), b.position.y());
    };
    std::sort(back->begin(), back->end(), before);
    std::sort(points.begin(), points.end(), before);
    ASSERT_EQ(back->size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i > 0 && points[i].position.x() - points[i - 1].position.x() < 2e-4) continue;  // may have changed places
      if (i + 1 < points.size() && points[i + 1].position.x() - points[i].position.x() < 2e-4) continue;
      ASSERT_LT(((*back)[i].position - points[i].position).cwiseAbs().maxCoeff(), 0.5001e-4);
      ASSERT_EQ((*back)[i].colour, points[i].colour);
      ASSERT_EQ((*back)[i].classification, points[i].classification);
    }
  }
}

TEST_F(Copc, AStoppedRunLeavesNoFile) {
  std::stop_source stop;
  LasWriter::Options options;
  options.form = LasForm::kCopc;
  options.run.stop = stop.get_token();
  {
    auto writer = LasWriter::create(folder_ / "a.copc.laz", options);
    ASSERT_TRUE(writer->write(std::vector<CloudPoint>(10)));
    stop.request_stop();
    const auto finished = writer->finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().code, Errc::kCancelled);
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace collinea
