// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>

namespace collinea {

/// An amount of memory that several threads share: who wants more of it than is left waits, in the order of asking. A
/// thread that holds a part must not ask for another.
class SharedBudget {
 public:
  /// What a thread holds, until its end.
  class Part {
   public:
    Part(Part&& other) noexcept : room_(std::exchange(other.room_, nullptr)), bytes_(other.bytes_) {}
    Part& operator=(Part&&) = delete;
    ~Part() {
      if (room_) room_->give_back(bytes_);
    }

   private:
    friend class SharedBudget;
    Part(SharedBudget* room, std::size_t bytes) : room_(room), bytes_(bytes) {}
    SharedBudget* room_;
    std::size_t bytes_;
  };

  explicit SharedBudget(std::size_t bytes) : bytes_(bytes) {}

  /// Waits until that much is left; for more than there is in all, until nobody else holds a part.
  [[nodiscard]] Part take(std::size_t bytes);

  /// The most that was held at the same time.
  [[nodiscard]] std::size_t most_in_use() const;
  /// How many threads wait for a part.
  [[nodiscard]] std::uint64_t waiting() const;

 private:
  void give_back(std::size_t bytes);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  const std::size_t bytes_;
  std::size_t in_use_ = 0, most_in_use_ = 0;
  std::uint64_t asked_ = 0, served_ = 0;  // who asked n-th is served n-th
};

}  // namespace collinea
