// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/guarded.h"

#include <cstdio>
#include <exception>
#include <new>

namespace collinea {
namespace {

constexpr int kDefect = 1;

// Without allocation: there may be no memory left.
int defect(const char* what) {
  std::fprintf(stderr, "collinea has a defect, please report it: %s\n", what);
  return kDefect;
}

}  // namespace

int guarded(const std::function<int()>& work) noexcept {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return defect("the memory does not suffice, and this was not noticed before");
  } catch (const std::exception& error) {
    return defect(error.what());
  } catch (...) {
    return defect("an exception of unknown kind");
  }
}

}  // namespace collinea
