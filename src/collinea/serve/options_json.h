// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace collinea {

/// The options of every step as `describe` has them, for forms: [{"step", "group", "options": [{"name", "unit", "help",
/// "kind", "default", "min", "max", "automatic", "choices": [{"word", "meaning"}], "path"}]}]. "kind" is flag, whole,
/// number, text, path, word or word_or_text; bounds stand where there are some; "default" as project.json has it, null
/// or "auto" for what is chosen from the data; "path" is file, folder, file_or_folder, file_or_word or output.
[[nodiscard]] std::string options_json();

}  // namespace collinea
