// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace collinea {

/// Runs the program: what `work` returns, or 1 where an exception reaches us, which is a defect: everything that the
/// world can do wrong comes as an Error. Says so on stderr.
[[nodiscard]] int guarded(const std::function<int()>& work) noexcept;

}  // namespace collinea
