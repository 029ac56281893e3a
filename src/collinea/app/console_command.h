// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "collinea/app/console.h"
#include "collinea/app/flags.h"

namespace collinea {

/// A command with a console. What is asked of it is one value, with a member `console`: declare(flags, asked) makes the
/// flags of it, act(asked, console) does what they say and returns the text for standard output, or what went wrong.
template <class Asked>
[[nodiscard]] Command console_command(std::string name, std::string summary,
                                      std::function<void(Flags&, Asked&)> declare,
                                      std::function<Result<std::string>(Asked&, Console&)> act) {
  auto asked = std::make_shared<Asked>();
  return {std::move(name), std::move(summary), [asked, declare](Flags& flags) { declare(flags, *asked); },
          [asked, act](const Flags& flags) {
            const auto spelling = [&flags](const OptionName& option) { return flags.spelled(option); };
            auto console = Console::create(asked->console, spelling);
            if (!console) return complain(console.error(), spelling);
            const Result<std::string> text = act(*asked, *console);
            if (!text) return console->complain(text.error());
            std::fputs(text->c_str(), stdout);
            return 0;
          }};
}

}  // namespace collinea
