// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/ply.h"
#include "collinea/cloud/ply_reader.h"

#include <algorithm>
#include <array>
#include <optional>

#include "collinea/base/file_text.h"
#include "collinea/base/packed.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr std::size_t kPointBytes = 3 * 8 + 3 * 4 + 3 + 4 + 2;
// Begin and end of the header.
constexpr FileText kHeaderStart = "ply\nformat binary_little_endian 1.0\ncomment written by collinea, in metres\n";
constexpr FileText kHeaderEnd =
    "property float sigma_m\nproperty uchar images\nproperty uchar classification\nend_header\n";

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

std::optional<Type> type_of(std::string_view word) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (word == kNames[i][0] || word == kNames[i][1]) return Type(i);
  return std::nullopt;
}

struct Property {
  Type type;
  std::string name;
};

enum class Encoding { kText, kLittle, kBig };

struct Header {
  std::optional<Encoding> encoding;
  std::optional<std::uint64_t> vertices;
  std::vector<Property> properties;
  std::size_t bytes = 0;
};

template <class T>
double taken(Unpacker& unpacker, bool big) {
  if (!big) return double(unpacker.get<T>());
  std::string swapped(unpacker.get_bytes(sizeof(T)));
  std::reverse(swapped.begin(), swapped.end());
  return double(Unpacker(swapped).get<T>());
}

double take(Unpacker& unpacker, Type type, bool big) {
  switch (type) {
    case Type::kInt8:
      return taken<std::int8_t>(unpacker, big);
    case Type::kUint8:
      return taken<std::uint8_t>(unpacker, big);
    case Type::kInt16:
      return taken<std::int16_t>(unpacker, big);
    case Type::kUint16:
      return taken<std::uint16_t>(unpacker, big);
    case Type::kInt32:
      return taken<std::int32_t>(unpacker, big);
    case Type::kUint32:
      return taken<std::uint32_t>(unpacker, big);
    case Type::kFloat:
      return taken<float>(unpacker, big);
    case Type::kDouble:
      return taken<double>(unpacker, big);
  }
  return 0;
}

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[std::size_t(type)];
}

std::uint8_t byte_of(double value) { return value >= 0 && value <= 255 ? std::uint8_t(value) : std::uint8_t{0}; }

void set(CloudPoint& point, std::string_view name, double value) {
  constexpr std::array<std::string_view, 3> kPosition = {"x", "y", "z"}, kNormal = {"nx", "ny", "nz"},
                                            kColour = {"red", "green", "blue"};
  for (std::size_t i = 0; i < 3; ++i) {
    if (name == kPosition[i]) point.position[Eigen::Index(i)] = value;
    if (name == kNormal[i]) point.normal[Eigen::Index(i)] = float(value);
    if (name == kColour[i]) point.colour[i] = byte_of(value);
  }
  if (name == "sigma_m") point.sigma_m = float(value);
  if (name == "images") point.images = byte_of(value);
  if (name == "classification") point.classification = byte_of(value);
}

Result<Header> parse_header(std::string_view bytes) {
  const auto damaged = [](const std::string& what) { return fail(Errc::kBadFormat, "PLY header: " + what); };
  if (!bytes.starts_with("ply")) return fail(Errc::kBadFormat, "not a PLY file");
  Header header;
  bool other_first = false, in_vertices = false;
  for (std::size_t at = 0;;) {
    const auto end = bytes.find('\n', at);
    if (end == std::string_view::npos) return damaged("it never ends");
    const auto words = words_of(bytes.substr(at, end - at));
    at = end + 1;
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info" || words[0] == "ply") continue;
    if (words[0] == "end_header") {
      header.bytes = at;
      break;
    }
    if (words[0] == "format" && words.size() > 1) {
      if (words[1] == "ascii") header.encoding = Encoding::kText;
      if (words[1] == "binary_little_endian") header.encoding = Encoding::kLittle;
      if (words[1] == "binary_big_endian") header.encoding = Encoding::kBig;
    } else if (words[0] == "element" && words.size() > 2) {
      in_vertices = words[1] == "vertex";
      const auto count = integer(words[2]);
      if (!count || *count < 0) return damaged("a count is not a number");
      if (in_vertices) header.vertices = std::uint64_t(*count);
      other_first |= !header.vertices && *count > 0;
    } else if (words[0] == "property" && in_vertices) {
      const auto type = words.size() == 3 ? type_of(words[1]) : std::nullopt;
      if (!type) return damaged("a vertex property that is a list, or of unknown type");
      header.properties.push_back({*type, std::string(words[2])});
    }
  }
  if (!header.encoding) return damaged("no known format");
  if (other_first) return fail(Errc::kUnsupported, "PLY with something else before its vertices");
  if (!header.vertices || header.properties.empty()) return damaged("no vertices");
  return header;
}

Result<std::vector<CloudPoint>> parse_binary(const Header& header, std::string_view body) {
  std::size_t record = 0;
  for (const Property& property : header.properties) record += size_of(property.type);
  if (*header.vertices > body.size() / record) return fail(Errc::kBadFormat, "truncated PLY file");
  std::vector<CloudPoint> points(*header.vertices);
  Unpacker unpacker(body);
  for (CloudPoint& point : points)
    for (const Property& property : header.properties)
      set(point, property.name, take(unpacker, property.type, header.encoding == Encoding::kBig));
  return points;
}

Result<std::vector<CloudPoint>> parse_text(const Header& header, std::string_view body) {
  if (*header.vertices > body.size() / 2) return fail(Errc::kBadFormat, "truncated PLY file");
  std::vector<CloudPoint> points(*header.vertices);
  for (std::size_t i = 0, at = 0; i < points.size(); ++i) {
    const auto end = std::min(body.find('\n', at), body.size());
    const auto words = words_of(body.substr(std::min(at, body.size()), end - std::min(at, end)));
    at = end + 1;
    if (words.size() < header.properties.size())
      return fail(Errc::kBadFormat, "vertex " + std::to_string(i) + " of the PLY file is incomplete");
    for (std::size_t k = 0; k < header.properties.size(); ++k) {
      const auto value = number(words[k]);
      if (!value) return fail(Errc::kBadFormat, "vertex " + std::to_string(i) + " of the PLY file is not a number");
      set(points[i], header.properties[k].name, *value);
    }
  }
  return points;
}

}  // namespace

std::string PlyWriter::header() const {
  const std::string count = std::to_string(points_);
  std::string text = kHeaderStart;
  if (!comment_.empty()) text += "comment " + comment_ + "\n";
  text += "comment " + std::string(24 - count.size(), '-') + "\nelement vertex " + count + "\n";
  for (const char* name : {"x", "y", "z"}) text += std::string("property double ") + name + "\n";
  for (const char* name : {"nx", "ny", "nz"}) text += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"}) text += std::string("property uchar ") + name + "\n";
  return text + kHeaderEnd;
}

Result<PlyWriter> PlyWriter::create(const std::filesystem::path& path, const std::string& comment) {
  std::string line = comment;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  COLLINEA_TRY(OutputFile file, OutputFile::create(path));
  PlyWriter writer(std::move(file), std::move(line));
  writer.file_.write(writer.header());
  return writer;
}

void PlyWriter::write(std::span<const CloudPoint> points) {
  constexpr std::size_t kPiece = 8192;
  Packer packer;
  packer.reserve(std::min(points.size(), kPiece) * kPointBytes);
  for (const CloudPoint& point : points) {
    for (int i = 0; i < 3; ++i) packer.put(point.position[i]);
    for (int i = 0; i < 3; ++i) packer.put(point.normal[i]);
    for (const std::uint8_t channel : point.colour) packer.put(channel);
    packer.put(point.sigma_m);
    packer.put(point.images);
    packer.put(point.classification);
    if (packer.size() == kPiece * kPointBytes) {
      file_.write(packer.bytes());
      packer.clear();
    }
  }
  file_.write(packer.bytes());
  points_ += points.size();
}

Result<> PlyWriter::finish() {
  file_.write_at(0, header());
  return file_.finish();
}

Result<PlyReader> PlyReader::open(const std::filesystem::path& path) {
  constexpr std::size_t kLongestHeader = 4096;
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(Errc::kNotFound, "cannot read " + path.string());
  std::string start(kLongestHeader, '\0');
  file.read(start.data(), std::streamsize(start.size()));
  start.resize(std::size_t(file.gcount()));
  const auto end = start.find(kHeaderEnd);
  if (!start.starts_with(std::string_view(kHeaderStart)) || end == std::string::npos)
    return fail(Errc::kUnsupported, path.string() + ": not a point cloud as it is written here");
  COLLINEA_TRY(const Header header, parse_header(start));
  file.clear();
  file.seekg(std::streamoff(header.bytes));
  return PlyReader(std::move(file), path.string(), *header.vertices);
}

Result<std::vector<CloudPoint>> PlyReader::read(std::size_t most) {
  std::vector<CloudPoint> points(std::size_t(std::min<std::uint64_t>(most, left_)));
  std::string bytes(points.size() * kPointBytes, '\0');
  file_.read(bytes.data(), std::streamsize(bytes.size()));
  if (std::size_t(file_.gcount()) != bytes.size()) return fail(Errc::kBadFormat, name_ + ": truncated PLY file");
  left_ -= points.size();
  Unpacker unpacker(bytes);
  for (CloudPoint& point : points) {
    for (int i = 0; i < 3; ++i) point.position[i] = unpacker.get<double>();
    for (int i = 0; i < 3; ++i) point.normal[i] = unpacker.get<float>();
    for (std::uint8_t& channel : point.colour) channel = unpacker.get<std::uint8_t>();
    point.sigma_m = unpacker.get<float>();
    point.images = unpacker.get<std::uint8_t>();
    point.classification = unpacker.get<std::uint8_t>();
  }
  return points;
}

Result<std::vector<CloudPoint>> parse_ply(std::string_view bytes) {
  COLLINEA_TRY(const Header header, parse_header(bytes));
  const std::string_view body = bytes.substr(header.bytes);
  return header.encoding == Encoding::kText ? parse_text(header, body) : parse_binary(header, body);
}

Result<std::vector<CloudPoint>> read_ply(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string bytes, read_file(path));
  return parse_ply(bytes).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace collinea
