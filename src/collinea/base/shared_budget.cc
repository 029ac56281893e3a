// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/shared_budget.h"

#include <algorithm>

namespace collinea {

SharedBudget::Part SharedBudget::take(std::size_t bytes) {
  std::unique_lock lock(mutex_);
  const std::uint64_t turn = asked_++;
  changed_.wait(lock, [&] { return turn == served_ && (held_ == 0 || (held_ <= bytes_ && bytes <= bytes_ - held_)); });
  ++served_;
  held_ += bytes;
  most_held_ = std::max(most_held_, held_);
  changed_.notify_all();  // the next one may fit, too
  return {this, bytes};
}

std::size_t SharedBudget::most_held() const {
  const std::lock_guard lock(mutex_);
  return most_held_;
}

std::uint64_t SharedBudget::waiting() const {
  const std::lock_guard lock(mutex_);
  return asked_ - served_;
}

void SharedBudget::give_back(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  held_ -= bytes;
  changed_.notify_all();
}

}  // namespace collinea
