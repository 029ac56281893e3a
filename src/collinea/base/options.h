// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/word_or.h"
#include "collinea/base/words.h"

// Options are described once, by a static member `describe` of each options struct; range checks, the command line,
// JSON, the manual, forms and bindings all read this:
//
//     struct OrientOptions {
//       std::optional<Calibration> calibration;
//       double max_error_px = 3;
//       std::optional<std::filesystem::path> orientation;
//       InstrumentOptions instruments;
//
//       template <class Visit>
//       static void describe(Visit&& visit) {
//         using O = OrientOptions;
//         visit(Field{"calibration", &O::calibration, "", "camera parameters to find"}.or_auto("brown of many
//         images")); visit(Field{"max_error_px", &O::max_error_px, "px", "largest residual of a tie point's image",
//         0.1}); visit(Field{"orientation", &O::orientation, "", "orientation to start from"}.file_or_folder());
//         visit(Group{"instruments", &O::instruments});
//       }
//     };
namespace collinea {

/// What a path among the options leads to.
enum class PathKind {
  kNone,  ///< the option is no path
  kFile,
  kFolder,
  kFileOrFolder,
  kFileOrWord,  ///< text that is the name of a file when there is such a file
  kOutput,      ///< a file to be written
};

namespace detail {
template <class T>
struct Inner {
  using type = T;
};
template <class T>
struct Inner<std::optional<T>> {
  using type = T;
};
}  // namespace detail

/// What an option without std::optional around it holds.
template <class T>
using OptionValue = typename detail::Inner<std::decay_t<T>>::type;

/// One word that may be chosen, and what it means.
struct Choice {
  std::string_view word, meaning;
};

/// One field of an options struct. T is bool, a number, std::string, std::filesystem::path, an enumeration with words,
/// a word or something else (WordOr), or a std::optional of one (nothing = chosen from the data; the help says how).
template <class Owner, class T>
struct Field {
  std::string_view name;
  T Owner::*member;
  std::string_view unit;  ///< "px", "m", "deg", "1" ...
  std::string_view help;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  PathKind path = PathKind::kNone;
  std::optional<std::string_view> automatic = {};  ///< "auto" stands for nothing; what that means
  std::span<const OptionValue<T>> only = {};       ///< the values that may be chosen; empty: all that have words

  /// Nothing is written "auto"; the meaning is for lists of choices.
  [[nodiscard]] constexpr Field or_auto(std::string_view meaning) const {
    Field copy = *this;
    copy.automatic = meaning;
    return copy;
  }
  [[nodiscard]] constexpr Field one_of(std::span<const OptionValue<T>> values) const {
    Field copy = *this;
    copy.only = values;
    return copy;
  }
  [[nodiscard]] constexpr Field leads_to(PathKind kind) const {
    Field copy = *this;
    copy.path = kind;
    return copy;
  }
  [[nodiscard]] constexpr bool allows(const OptionValue<T>& value) const {
    bool allowed = only.empty();
    for (const auto& one : only) allowed |= one == value;
    return allowed;
  }
  /// The words there are to choose from, of a WordOr beside what else it may be; none for other types.
  [[nodiscard]] std::vector<Choice> choices() const {
    std::vector<Choice> out;
    if constexpr (Worded<OptionValue<T>>) {
      if (automatic) out.push_back({"auto", *automatic});
      for (const auto& entry : words(OptionValue<T>{}))
        if (allows(entry.value)) out.push_back({entry.word, entry.meaning});
    } else if constexpr (detail::kIsWordOr<OptionValue<T>>) {
      for (const auto& entry : OptionValue<T>::table()) out.push_back({entry.word, entry.meaning});
    }
    return out;
  }
};

// Explicit deduction guides of these three templates: clang before 17 makes none for aggregates.
template <class Owner, class T>
Field(std::string_view, T Owner::*, std::string_view, std::string_view, double = 0, double = 0) -> Field<Owner, T>;

/// Options inside others that are described among them: their fields stand beside the owner's.
template <class Owner, class T>
struct Part {
  T Owner::*member;
};
template <class Owner, class T>
Part(T Owner::*) -> Part<Owner, T>;

/// Options inside others that are a group of their own, with a heading and a JSON object beside that of the owner.
template <class Owner, class T>
struct Group {
  const char* name;
  T Owner::*member;
};
template <class Owner, class T>
Group(const char*, T Owner::*) -> Group<Owner, T>;

namespace detail {
template <class T>
inline constexpr bool kIsPart = false;
template <class Owner, class T>
inline constexpr bool kIsPart<Part<Owner, T>> = true;
template <class T>
inline constexpr bool kIsGroup = false;
template <class Owner, class T>
inline constexpr bool kIsGroup<Group<Owner, T>> = true;
}  // namespace detail

/// Calls visit(field, owner) for every field of the options and of their parts, in the order of the description; the
/// value is owner.*field.member. Groups are left to for_each_group().
template <class Options, class Visit>
void for_each_field(Options& options, Visit&& visit) {
  std::remove_const_t<Options>::describe([&](const auto& entry) {
    using Entry = std::decay_t<decltype(entry)>;
    if constexpr (detail::kIsPart<Entry>)
      for_each_field(options.*entry.member, visit);
    else if constexpr (!detail::kIsGroup<Entry>)
      visit(entry, options);
  });
}

/// Calls visit(name, options) for the options themselves and for every group inside them.
template <class Options, class Visit>
void for_each_group(const char* name, Options& options, Visit&& visit) {
  visit(name, options);
  std::remove_const_t<Options>::describe([&](const auto& entry) {
    if constexpr (detail::kIsGroup<std::decay_t<decltype(entry)>>)
      for_each_group(entry.name, options.*entry.member, visit);
  });
}

/// Copies the fields for which which(name) holds, those of parts too.
template <class Options, class Which>
void assign_fields(const Options& from, Options& to, Which&& which) {
  Options::describe([&](const auto& entry) {
    using Entry = std::decay_t<decltype(entry)>;
    if constexpr (detail::kIsPart<Entry>)
      assign_fields(from.*entry.member, to.*entry.member, which);
    else if constexpr (!detail::kIsGroup<Entry>) {
      if (which(entry.name)) to.*entry.member = from.*entry.member;
    }
  });
}

/// Why a number cannot be the value of an option: "max_ratio = 2 is out of range: 0 to 1".
[[nodiscard]] Error out_of_range(std::string_view name, std::string_view unit, double value, double min, double max);
/// Why a word cannot: "cloud = "laz2": choose las, laz or copc".
[[nodiscard]] Error not_a_choice(std::string_view name, std::string_view word, std::span<const Choice> choices);

/// Checks one value against its description.
template <class Owner, class T>
[[nodiscard]] Result<> validate_field(const Field<Owner, T>& field, const OptionValue<T>& value) {
  using Value = OptionValue<T>;
  if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
    const auto number = static_cast<double>(value);
    if (!(number >= field.min && number <= field.max))
      return tl::unexpected(out_of_range(field.name, field.unit, number, field.min, field.max));
  } else if constexpr (Worded<Value>) {
    if (!field.allows(value)) return tl::unexpected(not_a_choice(field.name, word_of(value), field.choices()));
  }
  return {};
}

/// Checks every field of the options, of their parts and groups against its own description.
template <class Options>
[[nodiscard]] Result<> validate(const Options& options) {
  Result<> verdict;
  for_each_group("", options, [&](const char*, const auto& group) {
    for_each_field(group, [&](const auto& field, const auto& owner) {
      const auto& value = owner.*field.member;
      if (!verdict) return;
      if constexpr (requires { value.has_value(); }) {
        if (value) verdict = validate_field(field, *value);
      } else {
        verdict = validate_field(field, value);
      }
    });
  });
  return verdict;
}

}  // namespace collinea
