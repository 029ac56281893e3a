// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace collinea {

/// Memory that this process may have [bytes]: the least of the machine's, the limit of address space (ulimit -v)
/// and that of its control group; 0 where none can be known.
[[nodiscard]] std::uint64_t usable_memory();

/// To be called before anything else: rasters and images, which come and go by hundreds of kilobytes, go back to the
/// system as soon as they are freed. By default the C library learns from the first that goes to keep the like of it in
/// its heaps, where what is small and stays keeps much of what was large from going back: an orthophoto of 400 images
/// then holds half as much again as it uses. The price is a few per cent of system time.
void give_large_memory_back();

/// Gives memory that was freed back to the system. The allocator keeps it for later, in pieces that may not fit what
/// comes next: called between parts of a long computation that hold different things, the later ones do not stand on
/// the peak of the earlier. Takes a few milliseconds.
void give_back_freed_memory();

}  // namespace collinea
