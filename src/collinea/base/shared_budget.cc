// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/shared_budget.h"

#include <algorithm>

namespace collinea {

SharedBudget::Part SharedBudget::take(std::size_t bytes) {
  std::unique_lock lock(mutex_);
  const std::uint64_t ticket = asked_++;
  changed_.wait(
      lock, [&] { return ticket == served_ && (in_use_ == 0 || (in_use_ <= bytes_ && bytes <= bytes_ - in_use_)); });
  ++served_;
  in_use_ += bytes;
  most_in_use_ = std::max(most_in_use_, in_use_);
  changed_.notify_all();  // the next one may fit, too
  return {this, bytes};
}

std::size_t SharedBudget::most_in_use() const {
  const std::lock_guard lock(mutex_);
  return most_in_use_;
}

std::uint64_t SharedBudget::waiting() const {
  const std::lock_guard lock(mutex_);
  return asked_ - served_;
}

void SharedBudget::give_back(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  in_use_ -= bytes;
  changed_.notify_all();
}

}  // namespace collinea
