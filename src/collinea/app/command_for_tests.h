// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "collinea/app/commands.h"

// The program as a user calls it, for tests of its commands.
namespace collinea::testing {

struct Outcome {
  int code = 0;
  std::string out, err;
};

/// What the program does with these arguments.
inline Outcome collinea_with(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "collinea");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.code = dispatch(static_cast<int>(argv.size()), argv.data(), all_commands());
  outcome.out = ::testing::internal::GetCapturedStdout();
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

}  // namespace collinea::testing
