// SPDX-License-Identifier: Apache-2.0
// The same for tests: what every file reads, and the test library.
#include "Precompiled.h"

#include <gtest/gtest.h>
