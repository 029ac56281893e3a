// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/semi_global.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/disparity_kernels.h"
#include "collinea/dense/internal/texture.h"

namespace collinea::dense {
namespace {

constexpr int kTileOverlap = 48;  // pixels: a path forgets its beginning after a few penalties for jumps
constexpr int kTileWidth = 2048;  // of what is kept, where the image is wider
constexpr int kColumnsAtATime = 64;
constexpr int kLargestCensusCost = kCostPerBit * kCensusBits;  // the scale of smoothness_for

int stride_of(int labels) { return (labels + kLabelUnit - 1) / kLabelUnit * kLabelUnit; }

// Cut into `parts` of about the same size.
int part_begin(int size, int parts, int i) { return int(std::int64_t(size) * i / parts); }

struct Freed {
  void operator()(void* memory) const { std::free(memory); }
};
template <class T>
using Room = std::unique_ptr<T[], Freed>;

// Memory without a value (it is written before it is read). Much of it in pages of 2 MB where the system has them: with
// small ones the kernel would spend as long on handing them out as the matching takes.
template <class T>
Room<T> room_for(std::size_t count) {
  constexpr std::size_t kLargePage = std::size_t(1) << 21, kPage = 4096;
  const std::size_t page = count * sizeof(T) > kLargePage / 2 ? kLargePage : kPage;
  const std::size_t bytes = (count * sizeof(T) + page - 1) / page * page;
  void* memory = std::aligned_alloc(page, bytes);
  if (!memory) throw std::bad_alloc();
  if (page == kLargePage) madvise(memory, bytes, MADV_HUGEPAGE);
  return Room<T>(static_cast<T*>(memory));
}

// A row in work: the path costs that leave it and what sees it from the right.
struct Slot {
  Room<std::uint8_t> memory;
  std::uint8_t* costs = nullptr;  // in it
  std::vector<std::uint8_t> label_costs, smallest, side, jumps;
  std::vector<std::uint8_t> here, above;  // grey values, the border repeated
  std::vector<std::uint16_t> sums, right_sum, right_label;
  std::vector<Best> best;
  std::vector<float> disparity;
};

class TileMatching {
 public:
  TileMatching(const DisparityCosts& costs, const GreyImage& left, int right_width, const GreyImage& small,
               const DisparityRange& range, int max_left_right_px, const StereoTile& tile, const Run& run,
               FloatImage& disparity)
      : costs_(costs), left_(left), small_(small), tile_(tile), run_(run), disparity_(disparity) {
    width_ = tile.x1 - tile.x0;
    height_ = tile.y1 - tile.y0;
    low_ = range.low;
    labels_ = range.high - range.low + 1;
    stride_ = stride_of(labels_);
    right_width_ = right_width;
    max_apart_ = max_left_right_px;
    const std::size_t elements = std::size_t(width_) * std::size_t(height_) * std::size_t(stride_);
    tolls_ = room_for<std::uint8_t>(elements);
    slots_.resize(std::size_t(std::max(run.threads, 1)) + 2);  // the last one is what lies outside
    for (Slot& slot : slots_) prepare(slot);
  }

  void match() {
    sweep(1);
    sweep(-1);
  }

 private:
  void prepare(Slot& slot) {
    // guards 255; outside nothing has been paid, but guards stay
    // Slots begin at different positions of a page of 4 KB: where a load and a store before it share the lower bits of
    // their addresses, the processor takes them for the same.
    constexpr std::size_t kShift = 11 * 64, kPage = 4096;
    const std::size_t shift = std::size_t(&slot - slots_.data()) * kShift % kPage;
    const std::size_t bytes = PathRow::offset(width_ + 1, 0, stride_);
    slot.memory = room_for<std::uint8_t>(bytes + shift);
    slot.costs = slot.memory.get() + shift;
    std::fill_n(slot.costs, bytes, std::uint8_t(255));
    for (int x = -1; x <= width_; ++x)
      for (int p = 0; p < 3; ++p)
        if (x < 0 || x == width_ || &slot == &slots_.back())
          std::fill_n(slot.costs + PathRow::offset(x, p, stride_), labels_, std::uint8_t(0));
    slot.smallest.assign(std::size_t(width_ + 2) * 4, 0);
    slot.side.assign(std::size_t(stride_ + 2 * kPathGuard) * 2, 255);
    slot.label_costs.resize(std::size_t(kColumnsAtATime) * std::size_t(stride_));
    slot.jumps.resize(std::size_t(width_ + kCensusSlack) * 4);
    slot.here.resize(std::size_t(width_ + kCensusSlack) + 1);
    slot.above.resize(slot.here.size());
    slot.sums.resize(std::size_t(stride_));
    slot.right_sum.resize(std::size_t(width_ + stride_));
    slot.right_label.resize(std::size_t(width_ + stride_ + 1));
    slot.best.resize(std::size_t(width_ + kCensusSlack));
    slot.disparity.resize(slot.best.size());
  }

  // However a row ends, also by an exception: those that wait for it go on.
  struct Finished {
    std::atomic<int>& done;
    int width;
    ~Finished() {
      done.store(width, std::memory_order_release);
      done.notify_all();
    }
  };

  void sweep(int sense) {
    std::vector<std::atomic<int>> done(static_cast<std::size_t>(height_));
    parallel_for(run_, std::size_t(height_), [&](std::size_t i) {
      const Finished finished{done[i], width_};
      const int y = tile_.y0 + (sense > 0 ? int(i) : height_ - 1 - int(i));
      const std::size_t rotating = slots_.size() - 1;
      Slot& slot = slots_[i % rotating];
      Slot& before = i ? slots_[(i - 1) % rotating] : slots_.back();
      RowOfSweep row = begin(y, sense, slot, before);
      for (int column = 0; column < width_;) {
        const int end = std::min(column + kColumnsAtATime, width_);
        costs_of(y, column, end, slot, row);
        if (i) wait_for(done[i - 1], std::min(end + 1, width_));
        sweep_columns(row, column, end);
        column = end;
        // Before the row counts as done: its slot is used again once enough later rows are.
        if (column == width_ && sense < 0 && y >= tile_.kept_y0 && y < tile_.kept_y1) take_disparities(y, slot);
        done[i].store(column, std::memory_order_release);
        if (run_.threads > 1) done[i].notify_all();
      }
    });
  }

  static void wait_for(const std::atomic<int>& done, int columns) {
    for (int seen = done.load(std::memory_order_acquire); seen < columns; seen = done.load(std::memory_order_acquire))
      done.wait(seen, std::memory_order_acquire);
  }

  RowOfSweep begin(int y, int sense, Slot& slot, Slot& before) {
    const std::size_t at = std::size_t(y - tile_.y0) * std::size_t(width_) * std::size_t(stride_);
    jumps(y, sense, slot);
    // the side's path begins outside: nothing paid
    std::fill_n(slot.side.data() + kPathGuard, labels_, std::uint8_t(0));
    if (sense < 0) std::fill(slot.right_sum.begin(), slot.right_sum.end(), std::uint16_t(0xFFFF));
    RowOfSweep row;
    row.sense = sense;
    row.width = width_, row.labels = labels_, row.stride = stride_;
    row.small = small_.row(y) + tile_.x0;
    row.large = slot.jumps.data();
    row.before = {before.costs, before.smallest.data()};
    row.now = {slot.costs, slot.smallest.data()};
    row.side = slot.side.data();
    row.tolls = tolls_.get() + at;
    row.sums = slot.sums.data();
    row.best = slot.best.data();
    row.right_sum = slot.right_sum.data(), row.right_label = slot.right_label.data();
    return row;
  }

  // Costs of the columns [from, to) in the order of the sweep. So few that they are still at hand when the sweep comes,
  // and again on the way up: that takes less time than to keep them.
  void costs_of(int y, int from, int to, Slot& slot, RowOfSweep& row) const {
    const int first = row.sense > 0 ? from : width_ - to, end = row.sense > 0 ? to : width_ - from;
    costs_.row(y, tile_.x0 + first, tile_.x0 + end, low_, labels_, stride_, slot.label_costs.data());
    row.costs = slot.label_costs.data();
    row.costs_from = first;
  }

  void jumps(int y, int sense, Slot& slot) const {
    const auto bordered = [&](int row, std::vector<std::uint8_t>& out) {
      const std::uint8_t* from = left_.row(row) + tile_.x0;
      out[0] = from[0];
      std::copy_n(from, width_, out.begin() + 1);
      out[std::size_t(width_) + 1] = from[width_ - 1];
    };
    bordered(y, slot.here);
    bordered(std::clamp(y - sense, tile_.y0, tile_.y1 - 1), slot.above);
    jump_row(slot.here.data() + 1, slot.above.data() + 1, sense, width_, slot.jumps.data());
  }

  void take_disparities(int y, Slot& slot) {
    FoundRow row;
    row.left = slot.here.data() + 1;
    row.best = slot.best.data();
    row.right_label = slot.right_label.data();
    row.width = width_, row.right_size = width_ + stride_;
    row.low = low_;
    row.first_right = -tile_.x0, row.end_right = right_width_ - tile_.x0;
    row.max_apart = max_apart_;
    disparities_of_row(row, slot.disparity.data());
    std::copy(slot.disparity.data() + tile_.kept_x0 - tile_.x0, slot.disparity.data() + tile_.kept_x1 - tile_.x0,
              disparity_.row(y) + tile_.kept_x0);
  }

  const DisparityCosts& costs_;
  const GreyImage& left_;
  const GreyImage& small_;
  const StereoTile& tile_;
  const Run& run_;
  FloatImage& disparity_;
  int width_ = 0, height_ = 0, low_ = 0, labels_ = 0, stride_ = 0, right_width_ = 0, max_apart_ = 0;
  Room<std::uint8_t> tolls_;
  std::vector<Slot> slots_;
};

}  // namespace

std::vector<StereoTile> stereo_tiles(int width, int height, int labels, std::size_t max_elements) {
  // so narrow that a tile of the least height fits
  const std::size_t column = std::size_t(std::min(height, 3 * kTileOverlap)) * std::size_t(stride_of(labels));
  const int most = int(std::min<std::size_t>(max_elements / column, std::size_t(kTileWidth + 2 * kTileOverlap)));
  const int kept_across = std::max(most - 2 * kTileOverlap, kTileOverlap);
  const int across = (width + kept_across - 1) / kept_across;
  const int widest = std::min(width, (width + across - 1) / across + 2 * kTileOverlap);
  const std::size_t row = std::size_t(widest) * std::size_t(stride_of(labels));
  // rows that fit beside the overlap; as many as the overlap at least
  const int fitting = int(std::min<std::size_t>(max_elements / row, std::size_t(height)));
  const int kept = fitting >= height ? height : std::max(fitting - 2 * kTileOverlap, kTileOverlap);
  const int down = (height + kept - 1) / kept;
  std::vector<StereoTile> tiles;
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i) {
      StereoTile t;
      t.kept_x0 = part_begin(width, across, i), t.kept_x1 = part_begin(width, across, i + 1);
      t.kept_y0 = part_begin(height, down, j), t.kept_y1 = part_begin(height, down, j + 1);
      t.x0 = std::max(t.kept_x0 - kTileOverlap, 0), t.x1 = std::min(t.kept_x1 + kTileOverlap, width);
      t.y0 = std::max(t.kept_y0 - kTileOverlap, 0), t.y1 = std::min(t.kept_y1 + kTileOverlap, height);
      tiles.push_back(t);
    }
  return tiles;
}

GreyImage small_changes(const GreyImage& left) {
  auto small = small_for_textures();
  for (auto& value : small) value = std::uint8_t(value * kLargestCost / kLargestCensusCost);
  GreyImage result = texture_around(left);
  for (auto& value : result.data) value = small[value];
  return result;
}

void match_tile(const DisparityCosts& costs, const GreyImage& left, int right_width, const GreyImage& small,
                const DisparityRange& range, int max_left_right_px, const StereoTile& tile, const Run& run,
                FloatImage& disparity) {
  TileMatching(costs, left, right_width, small, range, max_left_right_px, tile, run, disparity).match();
}

}  // namespace collinea::dense
