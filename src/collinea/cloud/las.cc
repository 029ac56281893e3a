// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/las.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "collinea/base/file_text.h"
#include "collinea/base/packed.h"

namespace collinea {
namespace {

constexpr std::size_t kHeaderBytes = 375;     // of LAS 1.4
constexpr std::uint32_t kMagic = 0x4653414c;  // "LASF"
constexpr std::uint16_t kWktBit = 1 << 4;
constexpr std::uint16_t kWktRecord = 2112, kExtraBytesRecord = 4, kLazRecord = 22204;
constexpr std::uint8_t kUnsignedChar = 1, kFloat = 9;  // data types of extra bytes
constexpr std::size_t kDescriptorBytes = 192;
constexpr FileText kSigmaText = "standard deviation [m]", kImagesText = "images that agree";  // of extra bytes
constexpr std::size_t kPiece = 8192;                                                          // points handled at once
constexpr std::size_t kExtraBytes = 5;                                                        // sigma_m and images
constexpr std::string_view kLazUser = "laszip encoded", kCopcUser = "copc";
constexpr std::uint16_t kCopcInfoRecord = 1, kCopcHierarchyRecord = 1000;
constexpr std::size_t kCopcInfoBytes = 160, kRecordHeaderBytes = 54, kLongRecordHeaderBytes = 60;
constexpr int kCompressedBit = 0x80;  // of the point format

// Bytes of the point formats 0..8 without extra bytes, and where the colour lies in them (0: none). Formats 4, 5 hold
// waveforms.
struct Format {
  std::size_t bytes, colour;
};
constexpr std::array<Format, 9> kFormats = {
    {{20, 0}, {28, 0}, {26, 20}, {34, 28}, {0, 0}, {0, 0}, {30, 0}, {36, 30}, {38, 30}}};

void put(Packer& packer, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) packer.put(v[i]);
}

// The header in front of a variable length record; the long form has 8 bytes for its length.
void put_record_header(Packer& packer, std::string_view user, std::uint16_t id, std::uint64_t length, bool extended,
                       std::string_view description) {
  packer.put(std::uint16_t{0});
  packer.put_text(user, 16);
  packer.put(id);
  if (extended)
    packer.put(length);
  else
    packer.put(std::uint16_t(length));
  packer.put_text(description, 32);
}

void put_extra_bytes_descriptor(Packer& packer, std::uint8_t type, std::string_view name, std::string_view what) {
  packer.put(std::uint16_t{0});
  packer.put(type);
  packer.put(std::uint8_t{0});
  packer.put_text(name, 32);
  packer.put_text("", 4 + 5 * 24);  // unused; no value, smallest, largest, scale, offset: none is stated
  packer.put_text(what, 32);
}

double scale_for(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest) {
  const double extent = (highest - lowest).cwiseAbs().maxCoeff();
  for (const double scale : {0.0001, 0.001, 0.01, 0.1})
    if (extent < 1e9 * scale) return scale;  // 32 bits reach to 4.3e9: room for points outside the stated bounds
  return std::max(1.0, extent / 1e9);
}

// To eight significant bits: more are noise, and noise cannot be compressed.
float rounded(float sigma) {
  const auto bits = std::bit_cast<std::uint32_t>(sigma);
  return std::isfinite(sigma) ? std::bit_cast<float>((bits + 0x8000u) & 0xffff0000u) : sigma;
}

bool fits_wkt_in_short_record(const std::string& wkt) { return wkt.size() + 1 <= 65535; }

}  // namespace

std::string las_file_name(std::string_view stem, LasForm form) {
  return std::string(stem) + (form == LasForm::kLas ? ".las" : form == LasForm::kLaz ? ".laz" : ".copc.laz");
}

LasWriter::LasWriter(OutputFile file, const Options& options)
    : file_(std::move(file)), extra_bytes_(options.extra_bytes) {
  header_.wkt = options.wkt;
  header_.software = "collinea " COLLINEA_VERSION;
  header_.scale.setConstant(scale_for(options.lowest, options.highest));
  for (int i = 0; i < 3; ++i) header_.offset[i] = std::round((options.lowest[i] + options.highest[i]) / 2);
  if (options.like) header_.scale = options.like->scale, header_.offset = options.like->offset;
  header_.lowest.setConstant(std::numeric_limits<double>::infinity());
  header_.highest.setConstant(-std::numeric_limits<double>::infinity());
  if (extra_bytes_) header_.extra_names = {"sigma_m", "images"};
}

Result<LasWriter> LasWriter::create(const std::filesystem::path& path, const Options& options) {
  if (!options.lowest.allFinite() || !options.highest.allFinite())
    return fail(Errc::kBadInput, path.string() + ": the bounds of the cloud are not finite");
  COLLINEA_TRY(OutputFile file, OutputFile::create(path));
  LasWriter writer(std::move(file), options);
  Packer records;
  const auto put_head = [&](std::string_view user, std::uint16_t id, std::size_t length, std::string_view description) {
    put_record_header(records, user, id, length, false, description);
    ++writer.records_;
  };
  if (options.form == LasForm::kCopc) {  // it must be the first
    put_head(kCopcUser, kCopcInfoRecord, kCopcInfoBytes, "COPC info VLR");
    records.put_text("", kCopcInfoBytes);  // known at the end
  }
  if (!options.wkt.empty() && fits_wkt_in_short_record(options.wkt)) {
    put_head("LASF_Projection", kWktRecord, options.wkt.size() + 1, "OGC WKT");
    records.put_text(options.wkt, options.wkt.size() + 1);
  }
  if (options.extra_bytes) {
    put_head("LASF_Spec", kExtraBytesRecord, 2 * kDescriptorBytes, "extra bytes");
    put_extra_bytes_descriptor(records, kFloat, "sigma_m", kSigmaText);
    put_extra_bytes_descriptor(records, kUnsignedChar, "images", kImagesText);
  }
  if (options.form != LasForm::kLas) {
    const LazLayout layout{true, false, options.extra_bytes ? kExtraBytes : 0};
    const bool copc = options.form == LasForm::kCopc;
    const std::string description = laz_description(layout, copc ? LazChunks::kOfAnySize : LazChunks::kOfOneSize);
    put_head(kLazUser, kLazRecord, description.size(), "compression");
    records.put_bytes(description);
    if (copc) {
      COLLINEA_TRY(CopcStream stream, CopcStream::create(path, layout, options.run));
      writer.copc_.emplace(std::move(stream));
    } else {
      writer.laz_.emplace(layout, options.run);
    }
  }
  writer.points_at_ = kHeaderBytes + records.size();
  writer.file_.write(std::string(kHeaderBytes, '\0'));  // its counts and bounds are known at the end
  writer.file_.write(records.bytes());
  if (writer.laz_) writer.laz_->begin(writer.file_);
  return writer;
}

Result<> LasWriter::write(std::span<const CloudPoint> points) {
  Packer packer;
  packer.reserve(std::min(points.size(), kPiece) * 41);
  for (const CloudPoint& point : points) {
    const Eigen::Vector3d cells = ((point.position - header_.offset).array() / header_.scale.array()).round();
    if (!(cells.cwiseAbs().maxCoeff() < 2147483647.0))
      return fail(Errc::kBadInput, "a point lies outside the bounds that were stated for the LAS file");
    const Eigen::Vector3d kept = header_.offset + cells.cwiseProduct(header_.scale);
    header_.lowest = header_.lowest.cwiseMin(kept);
    header_.highest = header_.highest.cwiseMax(kept);
    for (int i = 0; i < 3; ++i) packer.put(std::int32_t(cells[i]));
    packer.put(std::uint16_t{0});    // intensity
    packer.put(std::uint8_t{0x11});  // return 1 of 1
    packer.put(std::uint8_t{0});     // flags
    packer.put(point.classification);
    packer.put(std::uint8_t{0});   // user data
    packer.put(std::int16_t{0});   // scan angle
    packer.put(std::uint16_t{0});  // source
    packer.put(0.0);               // time
    for (const std::uint8_t channel : point.colour) packer.put(std::uint16_t(channel * 256));
    if (extra_bytes_) {
      packer.put(rounded(point.sigma_m));
      packer.put(point.images);
    }
    ++header_.points;
    if (packer.size() > kPiece * 36) {
      COLLINEA_TRY(write_records(packer.bytes()));
      packer.clear();
    }
  }
  return write_records(packer.bytes());
}

Result<> LasWriter::write_records(std::string_view records) {
  if (laz_) return laz_->add(records, file_);
  if (copc_) return copc_->add(records);
  file_.write(records);
  return {};
}

std::string LasWriter::header_bytes() const {
  Packer h;
  h.put_text("LASF", 4);
  h.put(std::uint16_t{0});  // file source
  h.put(kWktBit);           // required by point format 7, with or without a CRS
  h.put_text("", 16);       // GUID
  h.put(std::uint8_t{1});
  h.put(std::uint8_t{4});
  h.put_text("photogrammetry", 32);
  h.put_text(header_.software, 32);
  h.put(std::uint16_t{0});  // day and year of creation: left open, so that equal clouds are equal files
  h.put(std::uint16_t{0});
  h.put(std::uint16_t(kHeaderBytes));
  h.put(std::uint32_t(points_at_));
  h.put(records_);
  h.put(std::uint8_t(header_.point_format | (laz_ || copc_ ? kCompressedBit : 0)));
  h.put(std::uint16_t(kFormats[7].bytes + (extra_bytes_ ? kExtraBytes : 0)));
  h.put_text("", 4 + 20);  // counts of older versions: must be 0
  put(h, header_.scale);
  put(h, header_.offset);
  for (int i = 0; i < 3; ++i) {
    h.put(header_.points ? header_.highest[i] : 0.0);
    h.put(header_.points ? header_.lowest[i] : 0.0);
  }
  h.put(std::uint64_t{0});  // waveforms
  h.put(long_records_at_);
  h.put(long_records_);
  h.put(header_.points);
  h.put(header_.points);  // all are first returns
  h.put_text("", 14 * 8);
  COLLINEA_CHECK(h.size() == kHeaderBytes);
  return h.bytes();
}

Result<> LasWriter::finish() {
  if (laz_) {
    COLLINEA_TRY(laz_->finish(file_));
  }
  if (copc_) {
    COLLINEA_TRY(copc_->finish(file_, header_.scale, header_.offset));
  }
  const std::uint64_t end_of_points = file_.size();
  const auto write_long = [&](std::string_view user, std::uint16_t id, const std::string& content,
                              std::string_view description) {
    Packer record;
    put_record_header(record, user, id, content.size(), true, description);
    record.put_bytes(content);
    file_.write(record.bytes());
    long_records_at_ = end_of_points;
    ++long_records_;
  };
  if (copc_) {
    write_long(kCopcUser, kCopcHierarchyRecord, copc_->hierarchy(), "EPT hierarchy");
    file_.write_at(kHeaderBytes + kRecordHeaderBytes, copc_->info(end_of_points + kLongRecordHeaderBytes));
  }
  if (!header_.wkt.empty() && !fits_wkt_in_short_record(header_.wkt))
    write_long("LASF_Projection", kWktRecord, header_.wkt + '\0', "OGC WKT");
  file_.write_at(0, header_bytes());
  return file_.finish();
}

// --- reading ---------------------------------------------------------------------------------------------------------

namespace {

std::string until_zero(std::string_view text) { return std::string(text.substr(0, text.find('\0'))); }

}  // namespace

Result<LasReader> LasReader::open(const std::filesystem::path& path) {
  LasReader reader;
  reader.name_ = path.string();
  std::error_code error;
  reader.file_size_ = std::filesystem::file_size(path, error);
  reader.file_.reset(error ? nullptr : std::fopen(path.c_str(), "rb"));
  if (!reader.file_) return fail(Errc::kNotFound, reader.name_ + ": no such file");
  if (auto read = reader.read_header(); !read) return tl::unexpected(std::move(read).error().within(reader.name_));
  return reader;
}

Result<std::string> LasReader::bytes_at(std::uint64_t offset, std::uint64_t size) {
  if (offset > file_size_ || size > file_size_ - offset) return fail(Errc::kBadFormat, "truncated or damaged");
  std::string bytes(size, '\0');
  const bool got =
      ::fseeko(file_.get(), ::off_t(offset), SEEK_SET) == 0 && std::fread(bytes.data(), 1, size, file_.get()) == size;
  if (!got) return fail(Errc::kBadFormat, "cannot be read");
  return bytes;
}

Result<> LasReader::read_header() {
  constexpr std::size_t kOldHeaderBytes = 227;
  COLLINEA_TRY(std::string bytes, bytes_at(0, std::min<std::uint64_t>(file_size_, kHeaderBytes)));
  const bool long_enough = bytes.size() >= kOldHeaderBytes;
  bytes.resize(kHeaderBytes, '\0');
  Unpacker h(bytes);
  if (!long_enough || h.get<std::uint32_t>() != kMagic) return fail(Errc::kBadFormat, "not a LAS file");
  h.get_bytes(20);
  const int major = h.get<std::uint8_t>();
  header_.minor_version = h.get<std::uint8_t>();
  h.get_bytes(32);
  header_.software = until_zero(h.get_bytes(32));
  h.get_bytes(4);
  const auto header_bytes = h.get<std::uint16_t>();
  points_at_ = h.get<std::uint32_t>();
  const auto records = h.get<std::uint32_t>();
  header_.point_format = h.get<std::uint8_t>();
  record_bytes_ = h.get<std::uint16_t>();
  header_.points = h.get<std::uint32_t>();
  h.get_bytes(20);
  for (auto* v : {&header_.scale, &header_.offset})
    for (int i = 0; i < 3; ++i) h.get((*v)[i]);
  for (int i = 0; i < 3; ++i) {
    h.get(header_.highest[i]);
    h.get(header_.lowest[i]);
  }
  h.get<std::uint64_t>();
  const auto long_at = h.get<std::uint64_t>();
  const auto long_records = h.get<std::uint32_t>();
  const auto points = h.get<std::uint64_t>();
  if (major != 1 || header_.minor_version > 4) return fail(Errc::kUnsupported, "a LAS version we do not know");
  const bool new_header = header_.minor_version == 4 && header_bytes >= kHeaderBytes;
  if (new_header) header_.points = points;
  compressed_ = header_.point_format & kCompressedBit;
  header_.point_format &= kCompressedBit - 1;
  if (compressed_ && header_.point_format < 6)
    return fail(Errc::kUnsupported, "compressed (LAZ) with a point format before LAS 1.4: convert it to LAS first");
  if (std::size_t(header_.point_format) >= kFormats.size() || kFormats[std::size_t(header_.point_format)].bytes == 0)
    return fail(Errc::kUnsupported, "point format " + std::to_string(header_.point_format) + " is not supported");
  base_bytes_ = kFormats[std::size_t(header_.point_format)].bytes;
  if (record_bytes_ < base_bytes_ || header_bytes < kOldHeaderBytes) return fail(Errc::kBadFormat, "damaged header");
  if (points_at_ > file_size_ || (!compressed_ && header_.points > (file_size_ - points_at_) / record_bytes_))
    return fail(Errc::kBadFormat, "truncated: it ends before its last point");
  const Eigen::Vector3d farthest = header_.offset.cwiseAbs() + 2147483648.0 * header_.scale.cwiseAbs();
  if (!farthest.allFinite()) return fail(Errc::kBadFormat, "damaged header");
  COLLINEA_TRY(read_records(header_bytes, records, false));
  if (new_header) {
    COLLINEA_TRY(read_records(long_at, long_records, true));
  }
  return compressed_ ? find_chunks() : Result<>{};
}

LazLayout LasReader::layout() const {
  return {header_.point_format >= 7, header_.point_format == 8, record_bytes_ - base_bytes_};
}

Result<> LasReader::find_chunks() {
  const auto read = [&](std::uint64_t offset, std::uint64_t size) { return bytes_at(offset, size); };
  auto chunks = laz_chunks(laz_description_, layout(), points_at_, header_.points, file_size_, read);
  if (!chunks) return tl::unexpected(std::move(chunks).error());
  chunks_ = std::move(*chunks);
  return {};
}

// Records: what is left of the expanded chunk, or what is asked for of a LAS file.
Result<std::string> LasReader::records(std::size_t count) {
  if (!compressed_) return bytes_at(points_at_ + next_ * record_bytes_, count * record_bytes_);
  if (expanded_from_ == expanded_.size()) {
    COLLINEA_CHECK(next_chunk_ < chunks_.size());
    const LazChunk& chunk = chunks_[next_chunk_++];
    COLLINEA_TRY(const std::string bytes, bytes_at(chunk.at, chunk.bytes));
    COLLINEA_TRY(std::string expanded, expand_laz_chunk(bytes, chunk.points, layout()));
    expanded_ = std::move(expanded);
    expanded_from_ = 0;
  }
  std::string bytes = expanded_.substr(expanded_from_, count * record_bytes_);
  expanded_from_ += bytes.size();
  return bytes;
}

Result<> LasReader::read_records(std::uint64_t at, std::uint32_t count, bool extended) {
  const std::size_t head = extended ? kLongRecordHeaderBytes : kRecordHeaderBytes;
  for (std::uint32_t i = 0; i < count; ++i) {
    COLLINEA_TRY(const std::string bytes, bytes_at(at, head));
    Unpacker h(bytes);
    h.get_bytes(2);
    const std::string user = until_zero(h.get_bytes(16));
    const auto id = h.get<std::uint16_t>();
    const std::uint64_t length = extended ? h.get<std::uint64_t>() : h.get<std::uint16_t>();
    const bool wkt = user == "LASF_Projection" && id == kWktRecord, laz = user == kLazUser && id == kLazRecord;
    if (wkt || laz || (user == "LASF_Spec" && id == kExtraBytesRecord)) {
      COLLINEA_TRY(std::string content, bytes_at(at + head, length));
      if (wkt)
        header_.wkt = until_zero(content);
      else if (laz)
        laz_description_ = std::move(content);
      else
        note_extra_bytes(content);
    }
    if (length > file_size_ - at - head) return fail(Errc::kBadFormat, "truncated or damaged");
    at += head + length;
  }
  return {};
}

void LasReader::note_extra_bytes(std::string_view descriptors) {
  constexpr std::array<std::size_t, 11> kSizes = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  std::size_t at = base_bytes_;
  while (descriptors.size() >= kDescriptorBytes) {
    Unpacker d(descriptors.substr(0, kDescriptorBytes));
    descriptors.remove_prefix(kDescriptorBytes);
    d.get_bytes(2);
    const auto type = d.get<std::uint8_t>();
    const auto options = d.get<std::uint8_t>();
    const std::string name = until_zero(d.get_bytes(32));
    header_.extra_names.push_back(name);
    const std::size_t size = type == 0 ? options : type < kSizes.size() ? kSizes[type] : 0;
    if (size == 0 || at + size > record_bytes_) return;  // what follows cannot be found
    if (name == "sigma_m" && type == kFloat) sigma_at_ = at;
    if (name == "images" && type == kUnsignedChar) images_at_ = at;
    at += size;
  }
}

CloudPoint LasReader::point_of(std::string_view record) const {
  CloudPoint point;
  Unpacker r(record);
  for (int i = 0; i < 3; ++i) point.position[i] = header_.offset[i] + r.get<std::int32_t>() * header_.scale[i];
  const bool old = header_.point_format < 6;
  const auto classification = std::uint8_t(record[old ? 15 : 16]);
  point.classification = old ? classification & 31 : classification;
  if (const std::size_t at = kFormats[std::size_t(header_.point_format)].colour) {
    Unpacker c(record.substr(at));
    for (std::uint8_t& channel : point.colour) channel = std::uint8_t(c.get<std::uint16_t>() >> 8);
  }
  if (sigma_at_) point.sigma_m = Unpacker(record.substr(*sigma_at_)).get<float>();
  if (images_at_) point.images = std::uint8_t(record[*images_at_]);
  return point;
}

Result<std::vector<CloudPoint>> LasReader::read(std::size_t count) {
  std::vector<CloudPoint> points;
  count = std::size_t(std::min<std::uint64_t>(count, header_.points - next_));
  points.reserve(count);
  while (points.size() < count) {
    auto bytes = records(std::min(count - points.size(), kPiece));
    if (!bytes) return tl::unexpected(std::move(bytes).error().within(name_));
    const std::size_t piece = bytes->size() / record_bytes_;
    for (std::size_t i = 0; i < piece; ++i)
      points.push_back(point_of(std::string_view(*bytes).substr(i * record_bytes_, record_bytes_)));
    next_ += piece;
  }
  return points;
}

}  // namespace collinea
