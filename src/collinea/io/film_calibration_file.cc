// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/film_calibration_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "collinea/base/file.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Words = std::vector<std::string_view>;

// A calibration that is being read, and what its parts are made of.
struct Reading {
  FilmCalibration calibration;
  std::set<std::string, std::less<>> seen;
  std::vector<double> radii_mm, distances_mm;  // of the table, as corrections
  double mark_sigma_mm = 0;
};

Result<std::vector<double>> numbers(const Words& words, std::size_t least, std::size_t most) {
  if (words.size() < least + 1 || words.size() > most + 1)
    return fail(Errc::kBadFormat, fmt::format("{} takes {}", words[0],
                                              least == most ? fmt::format("{} numbers", most)
                                                            : fmt::format("{} to {} numbers", least, most)));
  std::vector<double> values;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto value = finite_number(words[i]);
    if (!value) return fail(Errc::kBadFormat, fmt::format("\"{}\" is no number", words[i]));
    values.push_back(*value);
  }
  return values;
}

Result<std::vector<double>> positive(const Words& words, std::size_t least, std::size_t most) {
  COLLINEA_TRY(std::vector<double> values, numbers(words, least, most));
  for (const double value : values)
    if (!(value > 0)) return fail(Errc::kBadFormat, fmt::format("{} is a length above zero", words[0]));
  return values;
}

// A coordinate in brackets is not defined: it says about where the mark is.
bool is_in_brackets(std::string_view word) { return word.size() > 2 && word.front() == '(' && word.back() == ')'; }
std::string_view without_brackets(std::string_view word) {
  return is_in_brackets(word) ? word.substr(1, word.size() - 2) : word;
}

Result<> read_mark(const Words& words, Reading& reading) {
  if (words.size() < 4 || words.size() > 5)
    return fail(Errc::kBadFormat, "a mark has a name, x and y in mm, and a kind where it is known");
  COLLINEA_TRY(const std::vector<double> at,
               numbers({words[0], without_brackets(words[2]), without_brackets(words[3])}, 2, 2));
  CalibratedMark mark{.name = std::string(words[1]), .film_mm = {at[0], at[1]}, .sigma_mm = reading.mark_sigma_mm};
  if (is_in_brackets(words[2]) && is_in_brackets(words[3]))
    return fail(Errc::kBadFormat, fmt::format("mark {} has no coordinate that is defined", mark.name));
  if (is_in_brackets(words[2])) mark.coordinates = MarkCoordinates::kY;
  if (is_in_brackets(words[3])) mark.coordinates = MarkCoordinates::kX;
  if (words.size() == 5) {
    mark.kind = from_word<MarkKind>(words[4]);
    if (!mark.kind)
      return fail(Errc::kBadFormat,
                  fmt::format("\"{}\" is no kind of mark: {}", words[4], listed(only_words(kMarkKindWords))));
  }
  for (const CalibratedMark& other : reading.calibration.marks)
    if (other.name == mark.name) return fail(Errc::kBadFormat, fmt::format("mark {} stands here twice", mark.name));
  reading.calibration.marks.push_back(std::move(mark));
  return {};
}

Result<> read_lens(const Words& words, Reading& reading) {
  FilmCalibration& c = reading.calibration;
  if (words[0] == "radial_distortion_um") {
    COLLINEA_TRY(const auto values, numbers(words, 2, 2));
    if (values[0] < 0) return fail(Errc::kBadFormat, "a radius below zero");
    reading.radii_mm.push_back(values[0]);
    reading.distances_mm.push_back(-1e-3 * values[1]);
    return {};
  }
  const bool is_radial = words[0].starts_with("radial");
  const double sign = words[0].ends_with("_distortion") ? -1 : 1;
  COLLINEA_TRY(const auto values, is_radial ? numbers(words, 1, 4) : numbers(words, 2, 2));
  for (std::size_t i = 0; i < values.size(); ++i) (is_radial ? c.radial[i] : c.decentring[i]) = sign * values[i];
  return {};
}

Result<> read_length(const Words& words, Reading& reading) {
  FilmCalibration& c = reading.calibration;
  if (words[0] == "principal_distance_mm") {
    COLLINEA_TRY(const auto values, positive(words, 1, 1));
    c.principal_distance_mm = values[0];
  } else if (words[0] == "mark_sigma_mm") {
    COLLINEA_TRY(const auto values, positive(words, 1, 1));
    reading.mark_sigma_mm = values[0];
  } else if (words[0] == "mark_size_mm") {
    COLLINEA_TRY(const auto values, positive(words, 1, 2));
    c.mark_size_mm = values[0];
    c.line_mm = values.size() > 1 ? values[1] : values[0] / 10;
  } else if (words[0] == "film_size_mm") {
    COLLINEA_TRY(const auto values, positive(words, 2, 2));
    c.size_mm = {values[0], values[1]};
  } else if (words[0] == "image_size_mm") {
    COLLINEA_TRY(const auto values, positive(words, 2, 2));
    c.image_size_mm = Eigen::Vector2d(values[0], values[1]);
  } else {
    COLLINEA_TRY(const auto values, numbers(words, 2, 2));
    (words[0] == "principal_point_mm" ? c.principal_point_mm : c.symmetry_point_mm) = {values[0], values[1]};
  }
  return {};
}

constexpr std::string_view kLengths[] = {"principal_distance_mm", "principal_point_mm", "symmetry_point_mm",
                                         "mark_sigma_mm",         "mark_size_mm",       "film_size_mm",
                                         "image_size_mm"};
constexpr std::string_view kLens[] = {"radial_correction", "radial_distortion", "radial_distortion_um",
                                      "decentring_correction", "decentring_distortion"};

bool is_one_of(std::string_view word, std::span<const std::string_view> list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

Result<> read_line(std::string_view line, Reading& reading) {
  const Words words = words_of(line);
  const std::string_view key = words[0];
  const bool repeats = key == "mark" || key == "mark_sigma_mm" || key == "radial_distortion_um";
  if (!reading.seen.emplace(key).second && !repeats)
    return fail(Errc::kBadFormat, fmt::format("{} stands here twice", key));
  if (key == "camera") {
    reading.calibration.camera = trimmed(line.substr(key.size()));
    return {};
  }
  if (key == "mark") return read_mark(words, reading);
  if (is_one_of(key, kLengths)) return read_length(words, reading);
  if (is_one_of(key, kLens)) return read_lens(words, reading);
  std::vector<std::string_view> all = {"camera", "mark"};
  all.insert(all.end(), std::begin(kLengths), std::end(kLengths));
  all.insert(all.end(), std::begin(kLens), std::end(kLens));
  return fail(Errc::kBadFormat, fmt::format("\"{}\" is none of {}", key, listed(all)));
}

// What the lines together make.
Result<FilmCalibration> finished(Reading reading) {
  FilmCalibration& c = reading.calibration;
  if (!(c.principal_distance_mm > 0))
    return fail(Errc::kBadFormat, "no line principal_distance_mm: the calibrated focal length");
  if (!reading.seen.contains("symmetry_point_mm")) c.symmetry_point_mm = c.principal_point_mm;
  const auto twice = [&](std::string_view a, std::string_view b) {
    return reading.seen.contains(a) && reading.seen.contains(b);
  };
  if (twice("radial_correction", "radial_distortion") || twice("radial_correction", "radial_distortion_um") ||
      twice("radial_distortion", "radial_distortion_um") || twice("decentring_correction", "decentring_distortion"))
    return fail(Errc::kBadFormat, "the distortion stands here in two forms; leave one");
  if (!reading.radii_mm.empty()) {
    const auto radial = fit_radial(reading.radii_mm, reading.distances_mm);
    if (!radial) return fail(Errc::kBadFormat, "the radii of the table of the distortion are not different");
    c.radial = *radial;
    double squares = 0;
    for (std::size_t i = 0; i < reading.radii_mm.size(); ++i) {
      const double r = reading.radii_mm[i], r2 = r * r;
      const auto& k = c.radial;
      const double fitted = r * (k[0] + r2 * (k[1] + r2 * (k[2] + r2 * k[3])));
      squares += (fitted - reading.distances_mm[i]) * (fitted - reading.distances_mm[i]);
    }
    c.radial_rms_mm = std::sqrt(squares / double(reading.radii_mm.size()));
  }
  return c;
}

}  // namespace

Result<FilmCalibration> parse_film_calibration(std::string_view text) {
  Reading reading;
  std::size_t number = 0;
  for (std::string_view line : lines_of(text)) {
    ++number;
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    COLLINEA_TRY(read_line(line, reading).map_error([&](Error e) {
      return std::move(e).within(fmt::format("line {}", number));
    }));
  }
  return finished(std::move(reading));
}

std::string text_of(const FilmCalibration& c) {
  std::string text;
  const auto line = [&](std::string_view word, std::initializer_list<double> values, std::string_view more = "") {
    text += word;
    for (const double value : values) text += fmt::format(" {:.10g}", value);
    text += fmt::format("{}{}\n", more.empty() ? "" : " ", more);
  };
  if (!c.camera.empty()) line("camera", {}, c.camera);
  line("principal_distance_mm", {c.principal_distance_mm});
  line("principal_point_mm", {c.principal_point_mm.x(), c.principal_point_mm.y()});
  line("symmetry_point_mm", {c.symmetry_point_mm.x(), c.symmetry_point_mm.y()});
  line("radial_correction", {c.radial[0], c.radial[1], c.radial[2], c.radial[3]});
  line("decentring_correction", {c.decentring[0], c.decentring[1]});
  line("film_size_mm", {c.size_mm.x(), c.size_mm.y()});
  if (c.image_size_mm) line("image_size_mm", {c.image_size_mm->x(), c.image_size_mm->y()});
  line("mark_size_mm", {c.mark_size_mm, c.line_mm});
  double sigma_mm = 0;
  for (const CalibratedMark& mark : c.marks) {
    if (mark.sigma_mm != sigma_mm && mark.sigma_mm > 0) line("mark_sigma_mm", {mark.sigma_mm});
    sigma_mm = mark.sigma_mm;
    const auto coordinate = [&](int axis, MarkCoordinates other) {
      const std::string value = fmt::format("{:.10g}", mark.film_mm[axis]);
      return mark.coordinates == other ? " (" + value + ")" : " " + value;
    };
    line("mark " + mark.name + coordinate(0, MarkCoordinates::kY) + coordinate(1, MarkCoordinates::kX), {},
         mark.kind ? word_of(*mark.kind) : "");
  }
  return text;
}

Result<FilmCalibration> read_film_calibration(const std::filesystem::path& path) {
  const auto within = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const std::string bytes, read_file(path));
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes).map_error(within));
  return parse_film_calibration(converted ? std::string_view(*converted) : std::string_view(bytes)).map_error(within);
}

}  // namespace collinea
