// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// Gives memory that was freed back to the system. The allocator keeps it for later, in pieces that may not fit what
/// comes next: called between parts of a long computation that hold different things, the later ones do not stand on
/// the peak of the earlier. Takes a few milliseconds.
void give_back_freed_memory();

}  // namespace collinea
