// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "collinea/base/run.h"

namespace collinea {

/// Calls work(i) once for every i in [0, count), on run.threads threads. Items are handed out in order; which thread
/// takes which is not fixed, so work(i) may write only to memory that belongs to item i: then results do not depend on
/// the number of threads. The first exception thrown by an item is thrown again here. When run.stop is requested no
/// further item starts; the caller must look at run.stopped() before it trusts the result.
void parallel_for(const Run& run, std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace collinea
