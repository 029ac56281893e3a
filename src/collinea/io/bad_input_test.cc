// SPDX-License-Identifier: Apache-2.0
// Files as people and spreadsheets make them: what each reader does with them, row by row. A row is refused with a
// message that says where and what, is read with the values that it means, or holds a slip that no reader can see: it
// is then read as it stands. What names such slips afterwards is in import/import_test.cc, where images and names are
// known, and in jobs/slip_test.cc and jobs/gross_file_test.cc, where the adjustment is.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "collinea/io/adjustment_file.h"
#include "collinea/io/control_file.h"
#include "collinea/io/geodetic_file.h"
#include "collinea/io/position_file.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

struct BadInput {
  enum class Outcome { kRefused, kRead, kLater };
  const char* what;
  std::string text;
  Outcome outcome;
  std::string piece;  ///< of the message; of the values where they are not those of the good file
};
using Rows = std::vector<BadInput>;

BadInput refused(const char* what, std::string text, std::string piece) {
  return {what, std::move(text), BadInput::Outcome::kRefused, std::move(piece)};
}
BadInput read_as_good(const char* what, std::string text) {
  return {what, std::move(text), BadInput::Outcome::kRead, ""};
}
BadInput read_with(const char* what, std::string text, std::string piece) {
  return {what, std::move(text), BadInput::Outcome::kRead, std::move(piece)};
}
BadInput slip(const char* what, std::string text, std::string piece) {
  return {what, std::move(text), BadInput::Outcome::kLater, std::move(piece)};
}

/// All that a reader made of a file.
using Summary = std::function<Result<std::string>(const std::string&)>;

void check(const std::string& good, const Rows& rows, const Summary& summary) {
  const auto expected = summary(good);
  EXPECT_TRUE(expected) << expected.error().message;
  if (!expected) return;
  for (const BadInput& row : rows) {
    SCOPED_TRACE(row.what);
    const auto found = summary(row.text);
    if (row.outcome == BadInput::Outcome::kRefused) {
      EXPECT_FALSE(found) << *found;
      if (found) continue;
      EXPECT_EQ(found.error().code, Errc::kBadFormat);
      EXPECT_NE(found.error().message.find(row.piece), std::string::npos) << found.error().message;
      continue;
    }
    EXPECT_TRUE(found) << found.error().message;
    if (!found) continue;
    EXPECT_EQ(found->find("nan, nan, nan"), std::string::npos) << *found;
    if (row.piece.empty()) {
      EXPECT_EQ(*found, *expected);
    } else {
      EXPECT_NE(found->find(row.piece), std::string::npos) << *found;
    }
    if (row.outcome == BadInput::Outcome::kLater) {
      EXPECT_NE(*found, *expected);
    }
  }
}

std::string with(std::string text, std::string_view was, std::string_view is) {
  const auto at = text.find(was);
  EXPECT_NE(at, std::string::npos) << was;
  return at == std::string::npos ? text : text.replace(at, was.size(), is);
}

std::string with_all(std::string text, std::string_view was, std::string_view is) {
  for (auto at = text.find(was); at != std::string::npos; at = text.find(was, at + is.size()))
    text.replace(at, was.size(), is);
  return text;
}

std::string without_line(const std::string& text, std::size_t line) {
  std::string kept;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (i + 1 != line) kept += std::string(lines[i]) + "\n";
  return kept;
}

std::string utf16(const std::string& text, bool big_endian, bool with_mark = true) {
  std::string out;
  const auto put = [&](unsigned char low, unsigned char high) {
    out += char(big_endian ? high : low);
    out += char(big_endian ? low : high);
  };
  if (with_mark) put(0xff, 0xfe);
  for (const char c : text) put(static_cast<unsigned char>(c), 0);
  return out;
}

// Rows that are the same for every reader.
Rows encodings(const std::string& good) {
  using namespace std::string_literals;
  const std::string half = good.substr(0, good.size() / 2);
  return {
      read_as_good("CRLF", with_all(good, "\n", "\r\n")),
      read_as_good("CR alone", with_all(good, "\n", "\r")),
      read_as_good("no end of the last line", good.substr(0, good.size() - 1)),
      read_as_good("blank lines between", with_all(good, "\n", "\n\n \n")),
      read_as_good("UTF-8 with a byte order mark", "\xef\xbb\xbf" + good),
      read_as_good("UTF-16, low byte first", utf16(good, false)),
      read_as_good("UTF-16, high byte first", utf16(good, true)),
      read_as_good("UTF-16 with CRLF", utf16(with_all(good, "\n", "\r\n"), false)),
      refused("UTF-16 without a mark", utf16(good, false, false), "UTF-16 without a byte order mark: save it as UTF-8"),
      refused("UTF-16 that breaks off", utf16(good, true) + "\x01", "UTF-16 and ends within a character"),
      refused("UTF-16 with half a pair", utf16(good, false) + "\x3d\xd8", "broken UTF-16: save it as UTF-8"),
      refused("UTF-32", "\xff\xfe\0\0"s + with_all(good, "\n", "\0\0\0\n"s), "UTF-32: save it as UTF-8"),
      refused("binary", half + "\0\x01\x02"s + good, "a byte of 0, which no text has"),
      refused("empty", "", ""),
      refused("a photograph", "\xff\xd8\xff\xe0\0\x10JFIF\0"s, ""),
      refused("a page of the web", "<!DOCTYPE html>\n<html><body>404</body></html>\n", "line 1")};
}

std::string words_of_vector(const Eigen::Vector3d& v) { return exact(v[0]) + ", " + exact(v[1]) + ", " + exact(v[2]); }

// --control

const std::string kControlCsv =
    "# collinea control, EPSG:32633\n"
    "point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role\n"
    "point, A1, 546812.31, 5338101.92, 352.18, 0.01, 0.01, 0.015, control\n"
    "point, A2, 546871.02, 5338120.44, 353.02, 0.01, 0.01, 0.015, check\n"
    "image, id, file, x_px, y_px, sigma_px\n"
    "image, A1, IMG_0003.jpg, 812.4, 1033.7, 0.3\n"
    "image, A2, IMG_0003.jpg, 1711.2, 640.9, 0.3\n";

const std::string kGcpList =
    "EPSG:32633\n"
    "546812.31 5338101.92 352.18 812.4 1033.7 IMG_0003.jpg A1\n"
    "546871.02 5338120.44 353.02 1711.2 640.9 IMG_0003.jpg A2\n";

Result<std::string> control_summary(const std::string& text) {
  COLLINEA_TRY(const ControlFile file, parse_control(text));
  std::string summary = file.crs + "\n";
  for (const ControlFilePoint& point : file.points)
    summary += point.name + ": " + words_of_vector(point.position_in_map) + " +- " + words_of_vector(point.sigma_m) +
               (point.role == ControlRole::kCheck ? " check\n" : " control\n");
  for (const ControlFileObservation& seen : file.observations)
    summary += seen.point + " in " + seen.file + ": " + exact(seen.pixel.x()) + ", " + exact(seen.pixel.y()) + " +- " +
               exact(seen.sigma_px) + "\n";
  return summary;
}

Rows rows_of_control_csv() {
  const std::string& good = kControlCsv;
  return {
      read_as_good("semicolons", with_all(good, ", ", ";")),
      read_as_good("tabs", with_all(good, ", ", "\t")),
      read_as_good("rows padded by a spreadsheet", with(good, "1033.7, 0.3\n", "1033.7, 0.3,,,\n,,,,,,,,\n")),
      refused("decimal commas between semicolons", with_all(with_all(good, ", ", ";"), ".", ","),
              "line 3: \"546812,31\" is not a coordinate (a decimal comma? Write 546812.31)"),
      refused("decimal commas between commas", with_all(good, ".", ","), "line 3: too many fields (decimal commas?)"),
      refused("decimal commas, no sigmas",
              with(good, "546812.31, 5338101.92, 352.18, 0.01, 0.01, 0.015, control", "546812,31, 5338101,92, 352,18"),
              "line 3: whole numbers alone, and standard deviations of metres: decimal commas?"),
      refused("one decimal comma, no sigmas", with(good, "352.18, 0.01, 0.01, 0.015, control", "352,18"),
              "line 3: 6 fields: a point row has 5, 8 or 9"),
      refused("a decimal comma in a mark", with(good, "812.4, 1033.7", "812,4, 1033.7"),
              "line 6: too many fields (decimal commas?)"),
      refused("semicolons in one row",
              with(good, "point, A2, 546871.02, 5338120.44, 353.02, 0.01, 0.01, 0.015, check",
                   "point; A2; 546871.02; 5338120.44; 353.02"),
              "line 4: a row starts with point, image or covariance (semicolons in the line; commas are expected)"),
      refused("blanks alone",
              with(good, "point, A2, 546871.02, 5338120.44, 353.02, 0.01, 0.01, 0.015, check",
                   "point A2 546871.02 5338120.44 353.02"),
              "line 4: a row starts with point, image or covariance (blanks in the line; commas are expected)"),
      refused("a missing northing", with(good, "5338101.92, ", ""), "line 3: \"control\" is not a standard deviation"),
      refused("a missing northing, no sigmas", with(good, "5338101.92, 352.18, 0.01, 0.01, 0.015, control", "352.18"),
              "line 3: a point row needs: point, id, easting, northing, height"),
      refused("a missing sigma", with(good, "0.01, 0.01, 0.015, control", "0.01, 0.015"), "line 3: 7 fields"),
      refused("broken off within a row", good.substr(0, good.find("5338120")), "line 4: a point row needs"),
      refused("broken off within a mark", good.substr(0, good.find(", 640.9")), "line 7: an image row needs"),
      refused("a word in place of a number", with(good, "352.18", "n/a"), "line 3: \"n/a\" is not a coordinate"),
      refused("the letter O", with(good, "546812.31", "5468l2.31"), "line 3: \"5468l2.31\" is not a coordinate"),
      refused("a unit behind the number", with(good, "352.18", "352.18 m"), "line 3: \"352.18 m\" is not a coordinate"),
      refused("an infinite coordinate", with(good, "352.18", "inf"), "line 3: \"inf\" is not a coordinate"),
      read_with("a height that is NaN is not surveyed", with(good, "353.02", "nan"), "352.18 +- 0.01, 0.01, inf check"),
      refused("a mark that is NaN", with(good, "812.4", "nan"), "line 6: x_px and y_px must be numbers"),
      refused("a sigma of 0", with(good, "0.01, 0.01, 0.015, control", "0, 0, 0, control"),
              "line 3: \"0\" is not a standard deviation"),
      refused("a negative sigma", with(good, "0.015, control", "-0.015, control"),
              "line 3: \"-0.015\" is not a standard"),
      refused("a sigma in pixels of 0", with(good, "1033.7, 0.3", "1033.7, 0"),
              "line 6: sigma_px must be a number above 0"),
      refused("a doubled id", with(good, "point, A2", "point, A1"), "line 4: point A1 is given twice"),
      refused("words in place of numbers",
              with(good, "546871.02, 5338120.44, 353.02, 0.01, 0.01, 0.015", "n/a, n/a, n/a, , ,"),
              "line 4: \"n/a\" is not a coordinate"),
      refused("a mark of no point", with(good, "image, A2", "image, A3"), "line 7: image row of a point A3"),
      refused("a point without an id", with(good, "point, A2", "point, "), "line 4: the point has no id"),
      refused("a role that is none", with(good, "check", "chk"), "line 4: role \"chk\" is neither control nor check"),
      refused("no CRS behind the comma", with(good, "EPSG:32633", "my map"), "line 1: not a coordinate system"),
      refused("junk between rows", with(good, "image, id", "=== images ===\nimage, id"), "line 5: a row starts with"),
      refused("a number without an end", with(good, "353.02", "353.02.1"), "line 4: \"353.02.1\" is not a coordinate"),
      slip("eastings and northings exchanged",
           with(with(good, "546812.31, 5338101.92", "5338101.92, 546812.31"), "546871.02, 5338120.44",
                "5338120.44, 546871.02"),
           "A1: 5338101.92, 546812.31"),
      slip("a decimal slip in a coordinate", with(good, "546812.31", "54681.231"), "A1: 54681.231"),
      slip("a lost sign", with(good, "352.18", "-352.18"), "-352.18 +-"),
      slip("two digits exchanged", with(good, "5338120.44", "5338210.44"), "5338210.44"),
      slip("heights in feet", with(with(good, "352.18", "1155.45"), "353.02", "1158.2"), "1155.45"),
      slip("sigmas in millimetres", with(good, "0.01, 0.01, 0.015, control", "10, 10, 15.0, control"), "10, 10, 15"),
      slip("column and row exchanged", with(good, "812.4, 1033.7", "1033.7, 812.4"), "1033.7, 812.4"),
      slip("a mark outside its image", with(good, "812.4", "81240"), "81240"),
      refused("a doubled mark", good + "image, A1, IMG_0003.jpg, 912.4, 1033.7, 0.3\n",
              "line 8: point A1 is measured twice in IMG_0003.jpg, elsewhere in line 6"),
      slip("an image that is not there", with(good, "A1, IMG_0003", "A1, IMG_0030"), "IMG_0030"),
      slip("degrees in a map of metres", with(good, "546812.31, 5338101.92", "15.63, 48.19"), "A1: 15.63, 48.19"),
  };
}

Rows rows_of_gcp_list() {
  const std::string& good = kGcpList;
  return {
      read_as_good("tabs", with_all(good, " ", "\t")),
      read_as_good("many blanks", with_all(good, " ", "    ")),
      read_as_good("commas", with_all(good, " ", ",")),
      read_as_good("semicolons", with_all(good, " ", ";")),
      refused("decimal commas", with_all(with_all(good, ".", ","), ",jpg", ".jpg"),
              "line 2: not of the form: x y z column row image [name] (a decimal comma? Write 546812.31)"),
      refused("decimal commas and no CRS", without_line(with_all(with_all(good, ".", ","), ",jpg", ".jpg"), 1),
              "line 1: not a coordinate system"),
      refused("a missing number", with(good, " 5338120.44", ""),
              "line 3: 4 numbers in front of the image, where line 2 has 5"),
      refused("a missing number above", with(good, " 352.18", ""), "line 2: 4 numbers in front of the image"),
      refused("a missing number between tabs", with_all(with(good, "5338120.44", ""), " ", "\t"),
              "line 3: not of the form"),
      refused("a missing column between commas", with_all(with(good, "1711.2", ""), " ", ","),
              "line 3: not of the form"),
      read_with("a missing height between tabs", with_all(with(good, "353.02", ""), " ", "\t"),
                "352.18 +- 0.02, 0.02, inf"),
      read_with("a missing height between semicolons", with_all(with(good, "353.02", ""), " ", ";"),
                "352.18 +- 0.02, 0.02, inf"),
      read_with("a height that is NaN", with(good, "353.02", "NaN"), "352.18 +- 0.02, 0.02, inf"),
      refused("a number too many", with(good, "1033.7", "1033.7 0.5"), "line 2: not of the form"),
      refused("two numbers too many", with(good, "1033.7", "1033.7 0.5 0.5"), "line 2: not of the form"),
      refused("two missing numbers", with(good, "353.02 1711.2 ", ""), "line 3: not of the form"),
      refused("broken off", good.substr(0, good.find(" 640.9")), "line 3: not of the form"),
      refused("a northing that is NaN", with(good, "5338120.44", "nan"), "line 3: not of the form"),
      refused("an infinite height", with(good, "353.02", "inf"), "line 3: not of the form"),
      refused("a row that is NaN", with(good, "640.9", "nan"), "line 3: not of the form"),
      refused("a word in place of a number", with(good, "5338120.44", "unknown"), "line 3: not of the form"),
      refused("no CRS known", with(good, "EPSG:32633", "the local system"), "line 1: not a coordinate system"),
      refused("a zone of no map", with(good, "EPSG:32633", "WGS84 UTM 73N"), "line 1: not a coordinate system"),
      refused("one name, two positions", with(good, "A2", "A1"), "line 3: point A1 had other coordinates before"),
      refused("the CRS alone", "EPSG:32633\n", "no control point found"),
      refused("latitude first in degrees", "EPSG:4326\n48.19 151.63 352 812 1033 a.jpg\n", "x must be the longitude"),
      slip("a decimal slip in a column", with(good, "812.4", "8124"), "8124, 1033.7"),
      refused("a doubled mark", good + "546812.31 5338101.92 352.18 900 1033.7 IMG_0003.jpg A1\n",
              "line 4: point A1 is measured twice in IMG_0003.jpg, elsewhere in line 2"),
      slip("rows counted upwards", with(good, "1033.7", "1966.3"), "1966.3"),
      slip("a southern zone", with(good, "EPSG:32633", "EPSG:32733"), "EPSG:32733"),
  };
}

// --positions

const std::string kPositions =
    "# collinea positions, EPSG:32633\n"
    "image, easting_m, northing_m, height_m, sigma_plan_m, sigma_height_m\n"
    "a.jpg, 546812.314, 5338101.927, 452.18, 0.012, 0.02\n"
    "b.jpg, 546871.022, 5338120.443, 452.91, 0.012, 0.02\n";

Result<std::string> position_summary(const std::string& text) {
  COLLINEA_TRY(const PositionFile file, parse_positions(text));
  std::string summary = file.crs + "\n";
  for (const PositionFileRow& row : file.rows) {
    summary += row.image + "#" + std::to_string(row.number) + ":";
    if (row.geographic) summary += " geographic " + words_of_vector(*row.geographic);
    if (row.in_map) summary += " map " + words_of_vector(*row.in_map);
    summary += " +- " + exact(row.sigma_m[0]) + "/" + exact(row.sigma_m[1]) + "/" + exact(row.sigma_m[2]);
    if (row.angles) summary += " kappa " + exact(row.angles->kappa_deg);
    summary += " " + row.taken + "\n";
  }
  return summary;
}

Rows rows_of_positions() {
  const std::string& good = kPositions;
  const std::string degrees = "image,latitude_deg,longitude_deg,height_m\n";
  return {
      read_as_good("semicolons", with_all(good, ", ", ";") + ";;;;;\n"),
      read_as_good("tabs", with_all(good, ", ", "\t")),
      refused("decimal commas between semicolons",
              with_all(with_all(with_all(good, ", ", ";"), ".", ","), ",jpg", ".jpg"),
              "line 3: easting_m \"546812,314\" is not a number (a decimal comma? Write 546812.314)"),
      refused("decimal commas between tabs", with_all(with(good, "452.18", "452,18"), ", ", "\t"),
              "line 3: height_m \"452,18\" is not a number (a decimal comma? Write 452.18)"),
      refused("decimal commas between commas", with(good, "452.18", "452,18"),
              "line 3: too many fields (decimal commas?)"),
      refused("blanks alone", with_all(good, ", ", " "), "(blanks in the line; commas are expected)"),
      refused("another separator in a row",
              with(good, "b.jpg, 546871.022, 5338120.443, 452.91, 0.012, 0.02",
                   "b.jpg;546871.022;5338120.443;452.91;0.012;0.02"),
              "line 4: 1 field where the first row names 6 columns"),
      refused("a missing field", with(good, "5338120.443, ", ""),
              "line 4: 5 fields where the first row names 6 columns"),
      refused("broken off", good.substr(0, good.find("8120.443")), "line 4: 3 fields where the first row names 6"),
      refused("a title that is no column", with(good, "easting_m", "east"), "line 2: there is no column \"east\""),
      refused("a column in feet", with(good, "height_m", "height_ft"), "line 2: there is no column \"height_ft\""),
      refused("a doubled column", with(good, "northing_m", "easting_m"), "line 2: column easting_m is there twice"),
      refused("a missing column", with(good, ", northing_m", ""), "line 2: columns belong together: easting_m"),
      refused("no titles", without_line(good, 2), "line 2: there is no column \"a.jpg\""),
      refused("titles alone", good.substr(0, good.find("a.jpg")), "no position found"),
      refused("a doubled image", with(good, "b.jpg", "a.jpg"), "line 4: a.jpg is there twice"),
      refused("an image without a name", with(good, "b.jpg", ""), "line 4: a row needs the name of an image"),
      refused("NaN", with(good, "452.91", "nan"), "line 4: height_m \"nan\" is not a number"),
      refused("inf", with(good, "452.91", "inf"), "line 4: height_m \"inf\" is not a number"),
      refused("a sigma of 0", with(good, "0.012", "0"), "line 3: a standard deviation must be above 0"),
      refused("a negative sigma", with(good, "0.012", "-0.012"), "line 3: a standard deviation must be above 0"),
      refused("half a position", with(good, "5338120.443", ""), "line 4: half a position of b.jpg"),
      read_with("a height that is not known", with(good, "452.91", ""), "5338120.443, nan"),
      refused("degrees and minutes", degrees + "a.jpg,48 11.2,15.6,400\n",
              "line 2: latitude_deg \"48 11.2\" is not a number"),
      refused("a letter behind degrees", degrees + "a.jpg,48.19N,15.6,400\n", "line 2: latitude_deg \"48.19N\""),
      refused("metres in columns of degrees", degrees + "a.jpg,5338101.9,546812.3,400\n",
              "line 2: there is no such latitude and longitude"),
      refused("longitude first, beyond 90", degrees + "a.jpg,151.2,-33.8,400\n", "line 2: there is no such latitude"),
      slip("a decimal comma in place of a sigma", with(good, "5338101.927, 452.18, 0.012", "5338101,927, 452"),
           "map 546812.314, 5338101, 927 +- 452/452/0.02"),
      slip("longitude first", degrees + "a.jpg,15.63,48.19,400\n", "geographic 15.63, 48.19"),
      slip("a lost sign", degrees + "a.jpg,33.86,151.2,40\n", "geographic 33.86, 151.2"),
      slip("a decimal slip", with(good, "546812.314", "54681.2314"), "map 54681.2314"),
      slip("a height in feet", with(good, "452.18", "1483.5"), "1483.5"),
      slip("images exchanged", with(with(good, "a.jpg", "x.jpg"), "b.jpg", "a.jpg"), "x.jpg"),
      slip("sigmas in millimetres", with(good, "0.012, 0.02", "12, 20"), "12/12/20"),
  };
}

const std::string kTimestamps =
    "2\t296288.242869\t[2211]\t     3,N\t     0,E\t    75,V\t47.6436873208,Lat\t16.4759271684,Lon\t512.998,Ellh\t"
    "0.014391, 0.013698, 0.029694\t50,Q\n"
    "3\t296289.777625\t[2211]\t    -5,N\t    -0,E\t    75,V\t47.6436479170,Lat\t16.4758945272,Lon\t512.996,Ellh\t"
    "0.014268, 0.013609, 0.029783\t50,Q\n";

Rows rows_of_timestamps() {
  const std::string& good = kTimestamps;
  return {
      read_as_good("blanks in place of tabs", with_all(good, "\t", " ")),
      refused("a missing column", with(good, "512.998,Ellh\t", ""), "line 1: there is no column"),
      refused("a missing column below", with(good, "512.996,Ellh\t", ""), "line 2: no line of a timestamp file"),
      refused("decimal commas", with(good, "47.6436479170", "47,6436479170"), "line 2: no line of a timestamp file"),
      refused("broken off", good.substr(0, good.size() - 40), "line 2: no line of a timestamp file"),
      refused("NaN", with(good, "512.996", "nan"), "line 2: no line of a timestamp file"),
      refused("a doubled exposure", with(good, "3\t296289", "2\t296289"),
              "line 2: exposure 2 is there twice, first in line 1"),
      refused("seconds beyond a week", with(good, "296289.777625", "896289.777625"),
              "line 2: no line of a timestamp file"),
      refused("a sigma of 0", with(good, "0.014268", "0"), "line 2: no line of a timestamp file"),
      slip("a decimal slip", with(good, "47.6436479170", "47.6536479170"), "47.653647917"),
  };
}

// --geodetic

const std::string kGeodetic =
    "from, to, distance_m, sigma_m, name, role\n"
    "A, B, 2.5000, 0.0005, scale bar 1, control\n"
    "C, D, 41.207, 0.003, , check\n";

const std::string kStation =
    "from,to,setup,direction_gon,sigma_direction_mgon,zenith_gon,sigma_zenith_mgon,distance_m,sigma_m,target_height_m\n"
    "S,A,1,100.1234,0.3,99.5,0.3,20.125,0.002,1.2\n"
    "S,B,1,210.4321,0.3,101.25,0.3,31.75,0.002,1.2\n";

Result<std::string> geodetic_summary(const std::string& text) {
  COLLINEA_TRY(const auto rows, parse_geodetic(text));
  std::string summary;
  for (const GeodeticFileRow& row : rows)
    summary += std::string(kGeodeticKindNames[std::size_t(row.kind)]) + " " + row.from + " " + row.to + " " +
               exact(row.value) + " +- " + exact(row.sigma) + " " + row.name + " " + row.setup + " " +
               exact(row.target_height_m) + (row.role == ControlRole::kCheck ? " check\n" : " control\n");
  return summary;
}

Rows rows_of_geodetic() {
  const std::string& good = kGeodetic;
  return {
      read_as_good("semicolons", with_all(good, ", ", ";")),
      read_as_good("tabs", with_all(good, ", ", "\t")),
      refused("decimal commas between semicolons", with_all(with_all(good, ", ", ";"), ".", ","),
              "line 2: distance_m \"2,5000\" is not a number (a decimal comma? Write 2.5000)"),
      refused("decimal commas between commas", with(good, "2.5000, 0.0005", "2,5000, 0,0005"),
              "line 2: too many fields (decimal commas?)"),
      refused("decimal commas, and no name", with(good, "2.5000, 0.0005, scale bar 1, control", "2,5000, 0,0005"),
              "line 2: role \"0005\" is neither control nor check"),
      refused("blanks alone", with_all(good, ", ", " "), "line 1: there is no column"),
      refused("a row of blanks", with(good, "C, D, 41.207, 0.003, , check", "C D 41.207 0.003"),
              "line 3: 1 field where the first row names 6 columns; an empty field keeps its separator (blanks in the "
              "line"),
      refused("a missing field", with(good, "41.207, ", ""), "line 3: 5 fields where the first row names 6 columns"),
      refused("a missing end", with(good, ", scale bar 1, control", ""),
              "line 2: 4 fields where the first row names 6"),
      refused("broken off", good.substr(0, good.size() - 14), "line 3: 4 fields where the first row names 6"),
      refused("a title that is no column", with(good, "distance_m", "length"), "line 1: there is no column \"length\""),
      refused("a column in millimetres", with(good, "distance_m", "distance_mm"),
              "line 1: there is no column \"distance_mm\""),
      refused("sigmas in millimetres", with(good, "sigma_m", "sigma_mm"), "line 1: there is no column \"sigma_mm\""),
      refused("no column of sigmas", with_all(with_all(with(good, " sigma_m,", ""), " 0.0005,", ""), " 0.003,", ""),
              "line 1: column distance_m needs a column sigma_distance_m"),
      refused("no titles", without_line(good, 1), "line 1: there is no column \"a\""),
      refused("NaN", with(good, "41.207", "nan"), "line 3: distance_m \"nan\" is not a number"),
      refused("inf", with(good, "0.003", "inf"), "line 3: sigma_m \"inf\" is not a number"),
      refused("a negative distance", with(good, "41.207", "-41.207"), "line 3: the distance C - D is not above 0"),
      refused("a sigma of 0", with(good, "0.003", "0"), "line 3: sigma_m must be above 0"),
      refused("no sigma", with(good, "0.003", ""), "line 3: the distance C - D has no standard deviation"),
      refused("a unit behind the number", with(good, "41.207", "41.207 m"), "line 3: distance_m \"41.207 m\""),
      refused("a point to itself", with(good, "C, D", "C, C"), "line 3: from and to are both C"),
      refused("one end missing", with(good, "C, D", "C, "), "line 3: a measurement needs the names of two points"),
      refused("no name", with(good, "C, D", ", D"), "line 3: a row needs the name of a point"),
      refused("nothing measured", with(good, "41.207", ""), "line 3: nothing is measured from C to D"),
      refused("a role that is none", with(good, "check", "both"), "line 3: role \"both\" is neither control nor check"),
      slip("a decimal slip", with(good, "41.207", "4.1207"), "4.1207"),
      slip("a distance in millimetres", with(good, "2.5000", "2500"), "2500 +-"),
      slip("a sigma in millimetres", with(good, "0.0005", "0.5"), "2.5 +- 0.5"),
      slip("a name that no point has", with(good, "C, D", "C, E"), "C E"),
      slip("measured twice", good + "A, B, 2.5100, 0.0005, scale bar 1, control\n", "2.51 +-"),
  };
}

Rows rows_of_station() {
  const std::string& good = kStation;
  return {
      read_as_good("semicolons", with_all(good, ",", ";")),
      refused("degrees in a column of gon, beyond the nadir", with(good, "101.25", "258.75"),
              "line 3: the zenith angle S - B is not between 0 (up) and 180 degrees"),
      refused("a zenith angle of the second face", with(good, "99.5", "300.5"),
              "line 2: the zenith angle S - A is not between"),
      refused("a direction beyond the circle", with(good, "210.4321", "2104.321"),
              "line 3: the direction S - B is beyond a full circle"),
      slip("gon in a column of degrees", with(good, "zenith_gon,", "zenith_deg,"), "S A"),
      slip("elevation in place of zenith", with(good, "99.5", "0.5"), "zenith"),
      slip("degrees in a column of gon", with(good, "100.1234", "90.1111"), "direction"),
      slip("the target's height forgotten", with(good, "0.002,1.2\n", "0.002,0\n"), "S A"),
  };
}

// adjust --import

const std::string kAdjustment =
    "collinea-adjustment 1\n"
    "camera wide 4000 3000 brown\n"
    "parameter wide f 3000 fixed\n"
    "image a.jpg wide\n"
    "image b.jpg wide\n"
    "pose a.jpg 0 0 100 0 0 0\n"
    "pose b.jpg 30 0 100 0 0 0\n"
    "control G1 10.5 20.25 0.5 0.01 0.01 0.02\n"
    "check G2 12.5 22.25 0.5 0.01 0.01 0.02\n"
    "position b.jpg 30 0 100 0.02 0.02 0.04\n"
    "ground distance G1 G2 2.83 0.002 control\n"
    "point 7 15 5 0\n"
    "measured_control a.jpg G1 2300.5 900.25 0.5\n"
    "measured_control b.jpg G1 1400.5 900.25 0.5\n"
    "measured_tie a.jpg 7 2450 1350 0.5\n"
    "measured_tie b.jpg 7 1550 1350 0.5\n";

Result<std::string> adjustment_summary(const std::string& text) {
  COLLINEA_TRY(const AdjustmentFile file, parse_adjustment_file(text));
  return adjustment_file_text(file);
}

Rows rows_of_adjustment() {
  const std::string& good = kAdjustment;
  return {
      read_as_good("tabs", with_all(good, " ", "\t")),
      read_as_good("remarks behind lines", with_all(good, "\n", " # so\n")),
      refused("semicolons", with_all(good, " ", ";"), "line 1: the file does not begin with \"collinea-adjustment 1\""),
      refused("semicolons below the title", "collinea-adjustment 1\n" + with_all(without_line(good, 1), " ", ";"),
              "line 2: \"camera;wide;4000;3000;brown\" is no keyword (semicolons in the line; blanks are expected)"),
      refused("commas below the title", "collinea-adjustment 1\n" + with_all(without_line(good, 1), " ", ", "),
              "line 2: \"camera,\" is no keyword (commas in the line; blanks are expected)"),
      refused("semicolons between numbers", with(good, "10.5 20.25 0.5 0.01", "10.5;20.25;0.5;0.01"),
              "expected: control NAME X Y Z SX SY SZ (semicolons in the line; blanks are expected)"),
      refused("a decimal comma in a coordinate", with(good, "20.25", "20,25"),
              "line 8: \"20,25\" is not a coordinate: a number is expected (a decimal comma? Write 20.25)"),
      refused("a decimal comma in a mark", with(good, "900.25", "900,25"), "line 13: \"900,25\" is not a row"),
      refused("a decimal comma in a sigma", with(good, "0.02 0.02 0.04", "0,02 0,02 0,04"),
              "line 10: \"0,02\" is not a standard deviation"),
      refused("a decimal comma in a parameter", with(good, "3000 fixed", "3000 0,5"), "(a decimal comma? Write 0.5)"),
      refused("another file", "x y z\n1 2 3\n", "line 1: the file does not begin with"),
      refused("a later version", with(good, "adjustment 1", "adjustment 2"), "line 1: only version 1"),
      refused("broken off within a line", good.substr(0, good.find("1350 0.5")),
              "line 15: measured_tie has 3 words behind it"),
      refused("broken off above the marks", good.substr(0, good.find("measured")), "ends without a measurement"),
      refused("a missing column", with(good, "10.5 20.25 0.5", "10.5 20.25"), "line 8: control has 6 words behind it"),
      refused("a missing column of a mark", with(good, "2300.5 ", ""),
              "line 13: measured_control has 4 words behind it"),
      refused("NaN", with(good, "20.25", "nan"), "line 8: \"nan\" is not a coordinate"),
      refused("inf", with(good, "2450", "inf"), "line 15: \"inf\" is not a column"),
      refused("a number too large", with(good, "20.25", "1e999"), "line 8: \"1e999\" is not a coordinate"),
      refused("a negative sigma", with(good, "0.01 0.01 0.02", "0.01 -0.01 0.02"),
              "line 8: \"-0.01\" is not a standard"),
      refused("a mark's sigma of 0", with(good, "1350 0.5", "1350 0"),
              "line 15: the standard deviation of a measurement"),
      refused("a doubled image", with(good, "image b.jpg", "image a.jpg"), "line 5: a second image \"a.jpg\""),
      refused("a doubled control point", with(good, "check G2", "check G1"), "line 9: a second point \"G1\""),
      refused("a doubled tie point", with(good, "point 7 15 5 0\n", "point 7 15 5 0\npoint 7 15 5 1\n"),
              "line 13: a second tie point 7"),
      refused("a doubled mark", with(good, "b.jpg 7", "a.jpg 7"),
              "line 16: point \"7\" is measured twice in \"a.jpg\""),
      refused("a doubled pose", with(good, "pose b.jpg", "pose a.jpg"), "line 7: a second pose of \"a.jpg\""),
      refused("a keyword misspelt", with(good, "position", "postion"), "line 10: \"postion\" is no keyword"),
      refused("an image that is not there", with(good, "measured_tie b", "measured_tie c"),
              "line 16: there is no image \"c.jpg\""),
      refused("a focal length in millimetres", with(good, "f 3000", "f 24mm"), "line 3: \"24mm\" is not a value"),
      refused("a focal length of 0", with(good, "f 3000", "f 0"), "line 3: a focal length is above 0"),
      refused("a size of 0", with(good, "4000 3000", "0 3000"), "line 2: width and height of an image"),
      refused("no focal length", without_line(good, 3), "camera \"wide\" has no focal length"),
      refused("a quote that stays open", with(good, "image b.jpg", "image \"b.jpg"),
              "line 5: a name in quotes does not end"),
      refused("a distance to nobody", with(good, "G1 G2 2.83", "G1 G3 2.83"),
              "line 11: there is no control or check point \"G3\""),
      refused("a negative distance", with(good, "2.83", "-2.83"), "line 11: a distance is above 0"),
      slip("a decimal slip in control", with(good, "20.25", "202.5"), "202.5"),
      slip("a lost sign", with(good, "10.5 20.25", "-10.5 20.25"), "-10.5"),
      slip("a column times ten", with(good, "2450", "24500"), "24500"),
      slip("column and row exchanged", with(good, "2300.5 900.25", "900.25 2300.5"), "900.25 2300.5"),
      slip("a focal length in millimetres, bare", with(good, "f 3000", "f 24"), "f 24 fixed"),
      slip("angles in gon", with(good, "100 0 0 0\npose b", "100 0 0 50\npose b"), "pose a.jpg"),
  };
}

Rows joined(std::initializer_list<Rows> parts) {
  Rows all;
  for (const Rows& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(BadInput, ControlAsCsv) {
  check(kControlCsv, joined({encodings(kControlCsv), rows_of_control_csv()}), control_summary);
}

TEST(BadInput, ControlAsGcpList) {
  check(kGcpList, joined({encodings(kGcpList), rows_of_gcp_list()}), control_summary);
}

TEST(BadInput, Positions) { check(kPositions, joined({encodings(kPositions), rows_of_positions()}), position_summary); }

TEST(BadInput, TimestampsOfDrones) { check(kTimestamps, rows_of_timestamps(), position_summary); }

TEST(BadInput, MeasurementsOnTheGround) {
  check(kGeodetic, joined({encodings(kGeodetic), rows_of_geodetic()}), geodetic_summary);
  check(kStation, rows_of_station(), geodetic_summary);
}

TEST(BadInput, AdjustmentFiles) {
  check(kAdjustment, joined({encodings(kAdjustment), rows_of_adjustment()}), adjustment_summary);
  EXPECT_TRUE(is_adjustment_file(utf16(kAdjustment, false)));
}

}  // namespace
}  // namespace collinea
